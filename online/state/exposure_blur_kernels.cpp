// Compiled once per instruction set into namespace HDRCAM_TARGET (see hdrcam_kernels() in CMakeLists.txt).
// A block of pixels at a time: each instant is placed first (arithmetic), then each channel is read (memory).
#include "online/state/exposure_blur_kernels.h"

#include <cstddef>

namespace hdrcam::HDRCAM_TARGET {
namespace {

constexpr float kLeastBlur = 0.3f;            // pixels: a shorter one changes nothing visible
constexpr int kLeastTaps = 3, kMostTaps = 9;  // instants per exposure
constexpr float kLongest = 64;                // pixels that the taps still resolve
constexpr int kBlock = 64;

inline float least(float a, float b) { return a < b ? a : b; }
inline float most(float a, float b) { return a > b ? a : b; }
inline float clamped(float v, float low, float high) { return least(most(v, low), high); }

// The instants of a block's exposures, by pixel; none where the motion is short.
struct Instants {
  alignas(64) float count[kBlock], share[kBlock];  // share: 1 / count
  int most = 0;
};

void count_instants(const float* dx, const float* dy, float fraction, int n, Instants& at) {
  for (int i = 0; i < n; ++i) {
    const float length = __builtin_sqrtf(dx[i] * dx[i] + dy[i] * dy[i]) * fraction;
    const float span = least(length, kLongest);
    const int whole = static_cast<int>(span);
    const float taps = static_cast<float>(whole) + (span > static_cast<float>(whole) ? 2.f : 1.f);
    const float count = clamped(taps, kLeastTaps, kMostTaps), moves = length >= kLeastBlur ? 1.f : 0.f;
    at.count[i] = moves * count, at.share[i] = moves / count;
  }
  float longest = 0;
  for (int i = 0; i < n; ++i) longest = most(longest, at.count[i]);
  at.most = static_cast<int>(longest);
}

void blur(const BlurBand& b) {
  const float right = static_cast<float>(b.cols - 1), bottom = static_cast<float>(b.rows - 1);
  const std::ptrdiff_t plane = static_cast<std::ptrdiff_t>(b.rows) * b.cols;
  Instants at;
  alignas(64) int place[kBlock];  // of the pixel to the upper left of what an instant shows
  alignas(64) float fx[kBlock], fy[kBlock], part[kBlock], sum[kBlurChannels][kBlock];
  for (int y = b.y0; y < b.y1; ++y)
    for (int x0 = 0; x0 < b.cols; x0 += kBlock) {
      const int n = b.cols - x0 < kBlock ? b.cols - x0 : kBlock;
      const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(y) * b.cols + x0;
      const float *dx = b.dx + first, *dy = b.dy + first;
      count_instants(dx, dy, b.fraction, n, at);
      __builtin_memset(sum, 0, sizeof sum);
      for (int k = 0; k < at.most; ++k) {
        const float from_start = static_cast<float>(k) + 0.5f;
        for (int i = 0; i < n; ++i) {
          const float px = static_cast<float>(x0 + i), py = static_cast<float>(y);
          const float instant = b.fraction * (from_start * at.share[i] - 0.5f);
          // what is seen then moves as the place does where it is seen
          const int qx = static_cast<int>(clamped(px + instant * dx[i], 0, right) + 0.5f);
          const int qy = static_cast<int>(clamped(py + instant * dy[i], 0, bottom) + 0.5f);
          const float sx = clamped(px + instant * b.dx[qy * b.cols + qx], 0, right);
          const float sy = clamped(py + instant * b.dy[qy * b.cols + qx], 0, bottom);
          const int cx = static_cast<int>(sx), cy = static_cast<int>(sy);
          const int ix = cx < b.cols - 2 ? cx : b.cols - 2, iy = cy < b.rows - 2 ? cy : b.rows - 2;
          place[i] = iy * b.cols + ix;
          fx[i] = sx - static_cast<float>(ix), fy[i] = sy - static_cast<float>(iy);
          part[i] = static_cast<float>(k) < at.count[i] ? at.share[i] : 0;
        }
        for (int c = 0; c < b.channels; ++c) {
          const float *above = b.radiance + c * plane, *below = above + b.cols;
          float* __restrict total = sum[c];
          for (int i = 0; i < n; ++i) {
            const int p = place[i];
            const float upper = above[p] + (above[p + 1] - above[p]) * fx[i];
            const float lower = below[p] + (below[p + 1] - below[p]) * fx[i];
            total[i] += part[i] * (upper + (lower - upper) * fy[i]);
          }
        }
      }
      for (int c = 0; c < b.channels; ++c) {
        const float* in = b.radiance + c * plane + first;
        float* out = b.difference + c * plane + first;
        for (int i = 0; i < n; ++i) out[i] = at.count[i] > 0 ? sum[c][i] - in[i] : 0;
      }
    }
}

}  // namespace

extern const ExposureBlurKernels kExposureBlurKernels;
const ExposureBlurKernels kExposureBlurKernels{&blur};

}  // namespace hdrcam::HDRCAM_TARGET
