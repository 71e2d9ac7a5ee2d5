#include "firmware_host/footage/white_level.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>

#include "capture/clip_policy.h"

namespace hdrcam {
namespace {

constexpr int kCodes = 256;
constexpr int kDarkestWhite = 128;    // codes of 255
constexpr double kLeastShare = 0.01;  // of the pixels, that are white
constexpr double kMostAbove = 0.1;    // of the white ones: what lies above is how compression smears them
constexpr std::size_t kMostExposures = 9;

// Pixels by the mean code of their channels, rounded to codes of 255.
class MeanCodes {
 public:
  MeanCodes(const Image<std::uint16_t>& codes, int bits)
      : codes_(codes), scale_(255.0 / ((1 << bits) - 1) / codes.channels()) {
    for (std::size_t i = 0; i < codes.plane_size(); ++i) ++pixels_[of(i)];
  }

  std::size_t of(std::size_t pixel) const {
    std::uint32_t sum = 0;
    for (int c = 0; c < codes_.channels(); ++c) sum += codes_.plane(c)[pixel];
    return static_cast<std::size_t>(std::lround(sum * scale_));
  }

  // The code of white, with one of either side: many pixels have it, and hardly any is brighter.
  std::optional<std::size_t> white() const {
    const auto most = std::max_element(pixels_.begin() + kDarkestWhite, pixels_.end());
    const auto begin = most - 1, end = most + std::min<std::ptrdiff_t>(2, pixels_.end() - most);
    const double white = std::accumulate(begin, end, 0.0), above = std::accumulate(end, pixels_.end(), 0.0);
    if (white < kLeastShare * static_cast<double>(codes_.plane_size())) return std::nullopt;
    if (above > kMostAbove * white) return std::nullopt;
    return static_cast<std::size_t>(most - pixels_.begin());
  }

 private:
  const Image<std::uint16_t>& codes_;
  const double scale_;
  std::array<std::uint32_t, kCodes> pixels_{};
};

// The mean code of a channel where the picture is white, codes of 255.
double mean_of_white(const Image<std::uint16_t>& codes, int bits, const MeanCodes& means, std::size_t white,
                     int channel) {
  double sum = 0, pixels = 0;
  for (std::size_t i = 0; i < codes.plane_size(); ++i) {
    const std::size_t mean = means.of(i);
    if (mean + 1 < white || mean > white + 1) continue;
    sum += codes.plane(channel)[i], ++pixels;
  }
  return sum / pixels * 255 / ((1 << bits) - 1);
}

}  // namespace

void WhiteLevel::observe(const RawFrame& frame) {
  if (camera_.linear || is_bayer(camera_.layout)) return;
  if (frame.codes.empty() || !frame.facts.has_exposure()) return;
  const double exposure_ev = std::log2(frame.facts.exposure_s * frame.facts.gain());
  constexpr double kSameExposure_ev = 0.25;
  const bool is_known = std::ranges::any_of(brightest_, [&](const BrightestCodes& seen) {
    return std::abs(seen.exposure_ev - exposure_ev) < kSameExposure_ev;
  });
  if (is_known || brightest_.size() == kMostExposures) return;
  const MeanCodes means(frame.codes, camera_.bits);
  const auto white = means.white();
  if (!white) return;
  BrightestCodes brightest{.exposure_ev = exposure_ev, .mean = static_cast<double>(*white)};
  for (int c = 0; c < 3; ++c)
    brightest.of_channel[static_cast<std::size_t>(c)] =
        mean_of_white(frame.codes, camera_.bits, means, *white, std::min(c, frame.codes.channels() - 1));
  brightest_.push_back(brightest);
}

std::string WhiteLevel::warning() const {
  constexpr double kApart_ev = 1, kAlike = 1.5;  // codes of 255
  constexpr double kClipped = static_cast<double>(clip_policy::kResponseMatch.brightest);
  const auto white = std::ranges::max_element(brightest_, {}, &BrightestCodes::mean);
  if (white == brightest_.end() || std::ranges::min(white->of_channel) >= kClipped) return "";
  const bool is_clipped = std::ranges::any_of(brightest_, [&](const BrightestCodes& other) {
    double differ = 0;
    for (std::size_t c = 0; c < 3; ++c)
      differ = std::max(differ, std::abs(other.of_channel[c] - white->of_channel[c]));
    return std::abs(other.exposure_ev - white->exposure_ev) >= kApart_ev && differ <= kAlike;
  });
  if (!is_clipped) return "";
  const auto& [red, green, blue] = white->of_channel;
  const std::string at =
      camera_.layout == PixelLayout::Mono
          ? fmt::format("{:.0f} of 255", red)
          : fmt::format("{:.0f} of 255 in red, {:.0f} in green and {:.0f} in blue", red, green, blue);
  return fmt::format(
      "the pictures clip at {}, and clipped light below 255 is taken for measured light; stretch the codes "
      "first (docs/import.md, White level)",
      at);
}

}  // namespace hdrcam
