#include "online/pictures/local_statistics.h"

#include "hal/core/mirrored.h"

namespace hdrcam {
namespace {

// variance: null for the mean alone
void over_windows(const Image<float>& in, int radius, Image<float>& mean, Image<float>* variance,
                  WorkerPool& pool) {
  mean.reshape_like(in);
  if (variance != nullptr) variance->reshape_like(in);
  pool.for_rows(in.rows(), [&](int y0, int y1) {
    for (int c = 0; c < in.channels(); ++c)
      for (int y = y0; y < y1; ++y)
        picture_kernels().window(window_at(in.plane(c), in.rows(), in.cols(), y, radius, mean.row(c, y),
                                           variance != nullptr ? variance->row(c, y) : nullptr));
  });
}

}  // namespace

WindowRow window_at(const float* plane, int rows, int cols, int y, int radius, float* mean, float* variance) {
  WindowRow window{.line = {}, .cols = cols, .radius = radius, .mean = mean, .variance = variance};
  for (int k = -radius; k <= radius; ++k)
    window.line[k + radius] = plane + static_cast<std::ptrdiff_t>(mirrored(y + k, rows)) * cols;
  return window;
}

void box_mean(const Image<float>& in, int radius, Image<float>& out, WorkerPool& pool) {
  over_windows(in, radius, out, nullptr, pool);
}

void local_contrast(const Image<float>& in, Image<float>& mean, Image<float>& variance, WorkerPool& pool) {
  over_windows(in, 1, mean, &variance, pool);
}

}  // namespace hdrcam
