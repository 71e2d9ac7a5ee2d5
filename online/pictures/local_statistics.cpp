#include "online/pictures/local_statistics.h"

#include "online/pictures/picture_kernels.h"

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
        picture_kernels().window({.plane = in.plane(c),
                                  .rows = in.rows(),
                                  .cols = in.cols(),
                                  .y = y,
                                  .radius = radius,
                                  .mean = mean.row(c, y),
                                  .variance = variance != nullptr ? variance->row(c, y) : nullptr});
  });
}

}  // namespace

void box_mean(const Image<float>& in, int radius, Image<float>& out, WorkerPool& pool) {
  over_windows(in, radius, out, nullptr, pool);
}

void local_contrast(const Image<float>& in, Image<float>& mean, Image<float>& variance, WorkerPool& pool) {
  over_windows(in, 1, mean, &variance, pool);
}

}  // namespace hdrcam
