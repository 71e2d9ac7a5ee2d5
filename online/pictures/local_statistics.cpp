#include "online/pictures/local_statistics.h"

#include <cmath>
#include <vector>

namespace hdrcam {
namespace {

int mirrored(int i, int n) {
  if (n == 1) return 0;
  if (i < 0) i = -i;
  if (i >= n) i = 2 * n - 2 - i;
  return std::clamp(i, 0, n - 1);
}

// sums over 2r+1 columns, mirrored; in and out are rows of n
void sum_columns(const float* in, int n, int radius, float* out) {
  for (int x = 0; x < n; ++x) {
    if (x >= radius && x < n - radius) continue;
    float sum = 0;
    for (int k = -radius; k <= radius; ++k) sum += in[mirrored(x + k, n)];
    out[x] = sum;
  }
  if (radius == 1)
    for (int x = 1; x < n - 1; ++x) out[x] = in[x - 1] + in[x] + in[x + 1];
  else
    for (int x = 2; x < n - 2; ++x) out[x] = (in[x - 2] + in[x - 1]) + in[x] + (in[x + 1] + in[x + 2]);
}

}  // namespace

void box_mean(const Image<float>& in, int radius, Image<float>& out, WorkerPool& pool) {
  const int rows = in.rows(), cols = in.cols();
  const auto width = static_cast<std::size_t>(cols);
  const float scale = 1.f / static_cast<float>((2 * radius + 1) * (2 * radius + 1));
  out.reshape_like(in);
  for (int c = 0; c < in.channels(); ++c)
    pool.for_rows(rows, [&](int y0, int y1) {
      thread_local std::vector<float> lines;
      lines.resize(2 * width);
      float *sum = lines.data(), *wide = sum + width;
      for (int y = y0; y < y1; ++y) {
        std::copy_n(in.row(c, mirrored(y - radius, rows)), width, sum);
        for (int k = 1 - radius; k <= radius; ++k) {
          const float* line = in.row(c, mirrored(y + k, rows));
          for (std::size_t x = 0; x < width; ++x) sum[x] += line[x];
        }
        sum_columns(sum, cols, radius, wide);
        float* target = out.row(c, y);
        for (std::size_t x = 0; x < width; ++x) target[x] = wide[x] * scale;
      }
    });
}

void local_contrast(const Image<float>& in, Image<float>& mean, Image<float>& variance, WorkerPool& pool) {
  const int rows = in.rows(), cols = in.cols();
  const auto width = static_cast<std::size_t>(cols);
  mean.reshape_like(in);
  variance.reshape_like(in);
  for (int c = 0; c < in.channels(); ++c)
    pool.for_rows(rows, [&](int y0, int y1) {
      thread_local std::vector<float> lines;
      lines.resize(4 * width);
      float *sum = lines.data(), *square = sum + width, *wide = square + width, *wide_square = wide + width;
      for (int y = y0; y < y1; ++y) {
        const float* a = in.row(c, mirrored(y - 1, rows));
        const float* b = in.row(c, y);
        const float* d = in.row(c, mirrored(y + 1, rows));
        for (std::size_t x = 0; x < width; ++x) {
          sum[x] = a[x] + b[x] + d[x];
          square[x] = a[x] * a[x] + b[x] * b[x] + d[x] * d[x];
        }
        sum_columns(sum, cols, 1, wide);
        sum_columns(square, cols, 1, wide_square);
        float *m = mean.row(c, y), *v = variance.row(c, y);
        for (std::size_t x = 0; x < width; ++x) {
          m[x] = wide[x] * (1 / 9.f);
          v[x] = std::max(0.f, wide_square[x] * (1 / 9.f) - m[x] * m[x]);
        }
      }
    });
}

}  // namespace hdrcam
