#include "online/response/smeared_white.h"

#include <algorithm>
#include <vector>

#include "capture/clip_policy.h"

namespace hdrcam {
namespace {

constexpr float kWhite = clip_policy::kResponseMatch.brightest;
constexpr float kNotSmeared = 200;  // codes: what is darker is another light, which motion brought here
constexpr int kAround = 2;          // px: a smaller light may have moved away

bool is_brighter_around(const Image<float>& codes, int channel, int y, int x, float than) {
  for (int dy = -kAround; dy <= kAround; ++dy) {
    const float* row = codes.row(channel, std::clamp(y + dy, 0, codes.rows() - 1));
    for (int dx = -kAround; dx <= kAround; ++dx)
      if (row[std::clamp(x + dx, 0, codes.cols() - 1)] <= than) return false;
  }
  return true;
}

// Every step-th line of a channel.
std::vector<float> sparse_codes(const Image<float>& codes, int channel, int step) {
  std::vector<float> sparse;
  for (int y = 0; y < codes.rows(); y += step)
    sparse.insert(sparse.end(), codes.row(channel, y), codes.row(channel, y) + codes.cols());
  return sparse;
}

}  // namespace

void SmearedWhite::add(const Image<float>& shorter, const Image<float>& longer, int channel, int step) {
  constexpr double kLeast = 0.02, kMost = 0.98;  // of the pixels
  constexpr double kSure = 0.6;                  // of the white pixels, the brightest
  std::vector<float> codes = sparse_codes(longer, channel, step);
  const auto white = std::count_if(codes.begin(), codes.end(), [](float code) { return code > kWhite; });
  const double share = static_cast<double>(white) / static_cast<double>(codes.size());
  if (share < kLeast || share > kMost) return;
  codes = sparse_codes(shorter, channel, step);
  const auto bound = codes.end() - static_cast<std::ptrdiff_t>(kSure * static_cast<double>(white)) - 1;
  std::nth_element(codes.begin(), bound, codes.end());
  for (int y = 0; y < longer.rows(); y += step) {
    const float *dark = shorter.row(channel, y), *light = longer.row(channel, y);
    for (int x = 0; x < longer.cols(); ++x) {
      if (dark[x] <= *bound || light[x] < kNotSmeared) continue;
      if (!is_brighter_around(shorter, channel, y, x, *bound)) continue;
      ++white_, smeared_ += light[x] <= kWhite ? 1 : 0;
    }
  }
}

double SmearedWhite::share() const {
  constexpr std::size_t kEnough = 100;  // pixels
  return white_ < kEnough ? 0 : static_cast<double>(smeared_) / static_cast<double>(white_);
}

}  // namespace hdrcam
