#include "online/state/exposure_blur.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace hdrcam {
namespace {

constexpr float kLeastBlur = 0.3f;            // pixels: a shorter one changes nothing visible
constexpr int kLeastTaps = 3, kMostTaps = 9;  // instants per exposure
constexpr float kLongest = 64;                // pixels that the taps still resolve

// Where a tap reads: the pixel to its upper left, and the fraction beyond it.
struct Tap {
  std::size_t at;
  float fx, fy;
};

}  // namespace

void blur_difference(const Image<float>& radiance, const Image<float>& flow, float fraction,
                     Image<float>& difference, WorkerPool& pool) {
  const int rows = radiance.rows(), cols = radiance.cols(), channels = radiance.channels();
  const auto pitch = static_cast<std::size_t>(cols);
  difference.reshape_like(radiance);
  if (rows < 2 || cols < 2) {
    difference.fill(0);
    return;
  }
  const float right = static_cast<float>(cols - 1), bottom = static_cast<float>(rows - 1);
  pool.for_rows(rows, [&](int y0, int y1) {
    std::array<Tap, kMostTaps> taps;
    for (int y = y0; y < y1; ++y) {
      const float *dx = flow.row(0, y), *dy = flow.row(1, y);
      for (int x = 0; x < cols; ++x) {
        const float length = std::sqrt(dx[x] * dx[x] + dy[x] * dy[x]) * fraction;
        if (!(length >= kLeastBlur)) {
          for (int c = 0; c < channels; ++c) difference.at(c, y, x) = 0;
          continue;
        }
        const int count =
            std::clamp(static_cast<int>(std::ceil(std::min(length, kLongest))) + 1, kLeastTaps, kMostTaps);
        const float px = static_cast<float>(x), py = static_cast<float>(y);
        for (int k = 0; k < count; ++k) {
          const float instant =
              fraction * ((static_cast<float>(k) + 0.5f) / static_cast<float>(count) - 0.5f);
          // what is seen then moves as the place does where it is seen
          const int qx = static_cast<int>(std::clamp(px + instant * dx[x], 0.f, right) + 0.5f);
          const int qy = static_cast<int>(std::clamp(py + instant * dy[x], 0.f, bottom) + 0.5f);
          const float sx = std::clamp(px + instant * flow.at(0, qy, qx), 0.f, right);
          const float sy = std::clamp(py + instant * flow.at(1, qy, qx), 0.f, bottom);
          const int ix = std::min(static_cast<int>(sx), cols - 2),
                    iy = std::min(static_cast<int>(sy), rows - 2);
          taps[static_cast<std::size_t>(k)] = {
              static_cast<std::size_t>(iy) * pitch + static_cast<std::size_t>(ix),
              sx - static_cast<float>(ix), sy - static_cast<float>(iy)};
        }
        for (int c = 0; c < channels; ++c) {
          const float* plane = radiance.plane(c);
          float sum = 0;
          for (int k = 0; k < count; ++k) {
            const Tap& tap = taps[static_cast<std::size_t>(k)];
            const float *a = plane + tap.at, *b = a + pitch;
            const float upper = a[0] + (a[1] - a[0]) * tap.fx, lower = b[0] + (b[1] - b[0]) * tap.fx;
            sum += upper + (lower - upper) * tap.fy;
          }
          difference.at(c, y, x) = sum / static_cast<float>(count) - radiance.at(c, y, x);
        }
      }
    }
  });
}

}  // namespace hdrcam
