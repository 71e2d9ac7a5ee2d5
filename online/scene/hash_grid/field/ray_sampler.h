// Chooses the samples of the fit: pixels (preferably clipped, disoccluded or badly fitted ones) and depths
// along a ray (around the surface of the last field, with some over the whole range). Inverse depth in [0,
// 1], near first. Thread-compatible.
#pragma once

#include <algorithm>
#include <vector>

#include "online/scene/hash_grid/field/compositing.h"
#include "online/scene/hash_grid/field/random.h"
#include "online/scene/hash_grid/field/window.h"

namespace hdrcam {

// Fills inverse_depth[count], near to far, and spacing[count] (optical length, arbitrary unit: kOpticalRange
// over the whole range). jitter in [0, 1) moves each sample within its stratum; 0.5 is the middle.
template <class T, class Jitter>
void place_samples(T guide, int count, Jitter&& jitter, T* inverse_depth, T* spacing) {
  using namespace ray_constants;
  if (count < kFewSamples) {
    for (int k = 0; k < count; ++k) inverse_depth[k] = 1 - (T(k) + T(jitter())) / T(count);
    if (count == 1) inverse_depth[0] = guide;
  } else {
    const int wide = std::max(1, count * kWide / kParts), close = count - wide;
    const T band = T(kBand) + T(kBandPerDepth) * guide;
    for (int k = 0; k < close; ++k)
      inverse_depth[k] =
          std::clamp(guide + band * (1 - 2 * (T(k) + T(jitter())) / T(close)), T(0), T(kNearestSample));
    for (int k = 0; k < wide; ++k) inverse_depth[close + k] = 1 - (T(k) + T(jitter())) / T(wide);
    std::sort(inverse_depth, inverse_depth + count, [](T a, T b) { return a > b; });
  }
  for (int k = 0; k < count; ++k)
    spacing[k] = k + 1 < count ? (inverse_depth[k] - inverse_depth[k + 1]) * T(kOpticalRange) : T(1);
}

// Chooses pixels of one frame with a probability in proportion to the interest of their tile.
class PixelPicker {
 public:
  static constexpr int kTile = 8;  // pixels
  struct Pixel {
    int x, y;
  };

  PixelPicker(int rows, int cols);

  // Interest from the base: mean gate of the tile (clipped or never seen) and lost flow (disoccluded).
  void look_at(const WindowFrame& frame);
  // Exponential average of the photometric misfit where a ray ended.
  void learn(int x, int y, float misfit);
  // Recomputes the distribution; uniform_share of the picks ignores interest.
  void prepare(float uniform_share);
  [[nodiscard]] Pixel pick(Pcg32& random) const;

 private:
  std::size_t tile_of(int x, int y) const {
    return static_cast<std::size_t>(y / kTile) * static_cast<std::size_t>(tile_cols_) +
           static_cast<std::size_t>(x / kTile);
  }

  int rows_, cols_, tile_rows_, tile_cols_;
  std::vector<float> interest_, misfit_, cumulative_;
};

}  // namespace hdrcam
