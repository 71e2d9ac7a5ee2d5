#include "online/response/smeared_white.h"

#include <algorithm>
#include <vector>

#include "capture/clip_policy.h"

namespace hdrcam {
namespace {

constexpr float kWhite = clip_policy::kResponseMatch.brightest;
constexpr float kNotSmeared = 200;  // codes: what is darker is another light, which motion brought here
constexpr int kAround = 2;          // px: a smaller light may have moved away

bool is_brighter_around(const SparseChannel& seen, int y, int x, float than) {
  const Image<float>& codes = seen.codes;
  for (int dy = -kAround; dy <= kAround; ++dy) {
    const float* row = codes.row(seen.channel, std::clamp(y + dy, 0, codes.rows() - 1));
    for (int dx = -kAround; dx <= kAround; ++dx)
      if (row[std::clamp(x + dx, 0, codes.cols() - 1)] <= than) return false;
  }
  return true;
}

}  // namespace

void SmearedWhite::add(const SparseChannel& shorter, const SparseChannel& longer) {
  constexpr double kLeast = 0.02, kMost = 0.98;  // of the pixels
  constexpr double kSure = 0.6;                  // of the white pixels, the brightest
  const auto white = static_cast<double>(longer.count([](float code) { return code > kWhite; }));
  const double share = white / static_cast<double>(longer.pixels());
  if (share < kLeast || share > kMost) return;
  std::vector<float> codes = shorter.plain_codes();
  const auto bound = codes.end() - static_cast<std::ptrdiff_t>(kSure * white) - 1;
  std::nth_element(codes.begin(), bound, codes.end());
  for (int y = 0; y < longer.codes.rows(); y += longer.step) {
    const float *dark = shorter.codes.row(shorter.channel, y), *light = longer.codes.row(longer.channel, y);
    for (int x = 0; x < longer.codes.cols(); ++x) {
      if (dark[x] <= *bound || light[x] < kNotSmeared) continue;
      if (!is_brighter_around(shorter, y, x, *bound)) continue;
      ++white_, smeared_ += light[x] <= kWhite ? 1 : 0;
    }
  }
}

double SmearedWhite::share() const {
  constexpr std::size_t kEnough = 100;  // pixels
  return white_ < kEnough ? 0 : static_cast<double>(smeared_) / static_cast<double>(white_);
}

}  // namespace hdrcam
