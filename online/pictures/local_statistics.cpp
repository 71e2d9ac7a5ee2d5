#include "online/pictures/local_statistics.h"

#include "online/pictures/picture_kernels.h"

namespace hdrcam {
namespace {

int mirrored(int i, int n) {
  i = std::abs(i);
  return std::clamp(i < n ? i : 2 * n - 2 - i, 0, n - 1);
}

// variance: null for the mean alone
void over_windows(const Image<float>& in, int radius, Image<float>& mean, Image<float>* variance,
                  WorkerPool& pool) {
  const int rows = in.rows();
  mean.reshape_like(in);
  if (variance != nullptr) variance->reshape_like(in);
  pool.for_rows(rows, [&](int y0, int y1) {
    for (int c = 0; c < in.channels(); ++c)
      for (int y = y0; y < y1; ++y) {
        WindowRow row{.lines = {},
                      .radius = radius,
                      .cols = in.cols(),
                      .mean = mean.row(c, y),
                      .variance = variance != nullptr ? variance->row(c, y) : nullptr};
        for (int k = 0; k <= 2 * radius; ++k) row.lines[k] = in.row(c, mirrored(y + k - radius, rows));
        picture_kernels().window(row);
      }
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
