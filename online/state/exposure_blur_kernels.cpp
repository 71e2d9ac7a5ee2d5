// Compiled once per instruction set into namespace HDRCAM_TARGET (see hdrcam_kernels() in CMakeLists.txt).
// Eight pixels at a time: each instant is placed first, then each channel is read.
#include "online/state/exposure_blur_kernels.h"

#include "hal/core/picture_lanes.h"
#include "online/state/pass_constants.h"

namespace hdrcam::HDRCAM_TARGET {
namespace {

using namespace pass_constants;

// The instants of eight pixels' exposures; none where the motion is short.
struct Instants {
  Lanes count, share;  // share: 1 / count
};
inline Instants instants_of(Lanes dx, Lanes dy, float fraction) {
  const Lanes length = root(dx * dx + dy * dy) * fraction, span = least(length, Lanes{} + kLongest);
  const Lanes wanted = kTapsPerPixel * span, complete = lanes(whole(wanted));
  const Lanes taps = complete + (wanted > complete ? Lanes{} + 2.f : Lanes{} + 1.f);
  const Lanes count = clamped(taps, kLeastTaps, kMostTaps);
  const Whole moves = length >= kLeastBlur;
  return {moves ? count : Lanes{}, moves ? 1 / count : Lanes{}};
}

// Where eight pixels see the scene at an instant of the exposure, in parts of the interval from its middle.
struct Seen {
  Whole corner;  // the pixel to the upper left
  Lanes fx, fy;
};
inline Seen seen(const BlurBand& b, Lanes px, float py, Lanes dx, Lanes dy, Lanes instant) {
  const float right = static_cast<float>(b.cols - 1), bottom = static_cast<float>(b.rows - 1);
  // what is seen then moves as the place does where it is seen
  const Nearest near = nearest(px + instant * dx, py + instant * dy, b.rows, b.cols);
  const Lanes sx = clamped(px + instant * read(b.dx, near), 0, right);
  const Lanes sy = clamped(py + instant * read(b.dy, near), 0, bottom);
  const Whole ix = least(whole(sx), Whole{} + (b.cols - 2)), iy = least(whole(sy), Whole{} + (b.rows - 2));
  return {iy * b.cols + ix, sx - lanes(ix), sy - lanes(iy)};
}

// The difference at `n` of eight pixels from x on.
template <int kChannels>
inline void blur_eight(const BlurBand& b, int x, int y, int n) {
  const std::ptrdiff_t plane = static_cast<std::ptrdiff_t>(b.rows) * b.cols;
  const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(y) * b.cols + x;
  const Lanes px = lanes(x + kEachLane), dx = load_some(b.dx + first, n), dy = load_some(b.dy + first, n);
  const auto [count, share] = instants_of(dx, dy, b.fraction);
  Lanes sum[kChannels]{};
  Whole goes_on = 0 < count;
  for (float k = 0; any_negative(goes_on); k += 1, goes_on = k < count) {
    const Lanes instant = b.fraction * ((k + 0.5f) * share - 0.5f), part = goes_on ? share : Lanes{};
    if (!any_negative(((instant < 0) | (instant > 0)) & goes_on)) {  // the middle: the pixels themselves
      for (int c = 0; c < kChannels; ++c) sum[c] += part * load_some(b.radiance + c * plane + first, n);
      continue;
    }
    const Seen at = seen(b, px, static_cast<float>(y), dx, dy, instant);
    if (in_a_row(at.corner))
      for (int c = 0; c < kChannels; ++c)
        sum[c] += part * between_in_a_row(b.radiance + c * plane + at.corner[0], b.cols, at.fx, at.fy);
    else
      for (int c = 0; c < kChannels; ++c)
        sum[c] += part * between_at(b.radiance + c * plane, b.cols, at.corner, at.fx, at.fy);
  }
  for (int c = 0; c < kChannels; ++c) {
    const std::ptrdiff_t i = c * plane + first;
    store_some(b.difference + i, count > 0 ? sum[c] - load_some(b.radiance + i, n) : Lanes{}, n);
  }
}

template <int kChannels>
void blur_band(const BlurBand& b) {
  for (int y = b.y0; y < b.y1; ++y)
    for (int x = 0; x < b.cols; x += kLanes) blur_eight<kChannels>(b, x, y, least(b.cols - x, kLanes));
}

void blur(const BlurBand& b) {
  static_assert(kBlurChannels == 3);
  constexpr void (*kBand[])(const BlurBand&) = {&blur_band<1>, &blur_band<2>, &blur_band<3>};
  kBand[b.channels - 1](b);
}

bool blurs(const float* dx, const float* dy, float fraction, int n) {
  Lanes longest2{};
  for (int i = 0; i < n; i += kLanes) {
    const int count = least(n - i, kLanes);
    const Lanes x = load_some(dx + i, count), y = load_some(dy + i, count);
    longest2 = most(x * x + y * y, longest2);
  }
  return any_negative(root(longest2) * fraction >= kLeastBlur);
}

}  // namespace

extern const ExposureBlurKernels kExposureBlurKernels;
const ExposureBlurKernels kExposureBlurKernels{&blur, &blurs};

}  // namespace hdrcam::HDRCAM_TARGET
