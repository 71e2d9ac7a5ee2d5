#include "firmware_host/footage/low_codes.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>

namespace hdrcam {
namespace {

constexpr int kBits = 16;
constexpr double kManyAreClipped = 1e-3;  // of the samples of a frame

}  // namespace

void LowCodes::observe(const Image<std::uint16_t>& codes) {
  const std::uint64_t frame = frames_++;
  if (camera_.bits != kBits || brightest_ >> kMost != 0 || codes.empty()) return;
  const std::uint16_t most = std::ranges::max(codes.samples());
  brightest_ = std::max(brightest_, most);
  const int bits = std::bit_width(most);
  if (bits < kFewest || bits > kMost || most != (1u << bits) - 1) return;
  const double share = static_cast<double>(std::ranges::count(codes.samples(), most)) /
                       static_cast<double>(codes.samples().size());
  Clipped& clipped = clipped_[static_cast<std::size_t>(bits - kFewest)];
  if (share > clipped.share) clipped = {share, frame};
}

std::string LowCodes::warning() const {
  const int bits = std::bit_width(brightest_);
  if (bits < kFewest || bits > kMost) return "";
  const Clipped& clipped = clipped_[static_cast<std::size_t>(bits - kFewest)];
  if (clipped.share < kManyAreClipped) return "";
  return fmt::format(
      "no code of 16 bits is above {}, and {:.2g} % of frame {} are at it: codes of {} bits in the lower "
      "bits of 16 look so, and come out nearly black; shift them up by {} (docs/recording.md, Bits)",
      brightest_, 100 * clipped.share, clipped.frame, bits, kBits - bits);
}

std::string LowCodes::suspicion() const {
  std::string sure = warning();
  const int bits = std::bit_width(brightest_);
  if (!sure.empty() || bits < kFewest || bits > kMost) return sure;
  return fmt::format(
      "no code of 16 bits is above {}: codes of fewer bits in the lower bits of 16 look so; if these are, "
      "shift them up, those of 12 bits by 4 (docs/recording.md, Bits)",
      brightest_);
}

}  // namespace hdrcam
