#include "online/pictures/warp.h"

#include <array>
#include <cmath>

namespace hdrcam {
namespace {

constexpr int kSubpixels = 32;

using Weights = std::array<float, 4>;

std::array<Weights, kSubpixels> make_cubic_weights() {
  std::array<Weights, kSubpixels> table{};
  constexpr float a = -0.5f;
  for (int i = 0; i < kSubpixels; ++i) {
    const float f = static_cast<float>(i) / kSubpixels;
    auto& w = table[static_cast<std::size_t>(i)];
    w[0] = ((a * (f + 1) - 5 * a) * (f + 1) + 8 * a) * (f + 1) - 4 * a;
    w[1] = ((a + 2) * f - (a + 3)) * f * f + 1;
    w[2] = ((a + 2) * (1 - f) - (a + 3)) * (1 - f) * (1 - f) + 1;
    w[3] = 1 - w[0] - w[1] - w[2];
  }
  return table;
}

const std::array<Weights, kSubpixels> kCubic = make_cubic_weights();

// A position split into whole pixels and 1/32 pixels.
struct Position {
  int x, y, fx, fy;
  Position(float px, float py, int rows, int cols) {
    // far outside or not finite: the border; keeps the integer conversion defined
    const float limit_x = static_cast<float>(cols + 4), limit_y = static_cast<float>(rows + 4);
    px = px > -4 ? (px < limit_x ? px : limit_x) : -4;
    py = py > -4 ? (py < limit_y ? py : limit_y) : -4;
    const int qx = static_cast<int>(std::floor(px * kSubpixels + 0.5f));
    const int qy = static_cast<int>(std::floor(py * kSubpixels + 0.5f));
    x = qx >> 5, y = qy >> 5, fx = qx & (kSubpixels - 1), fy = qy & (kSubpixels - 1);
  }
};

}  // namespace

void warp_cubic(const Image<float>& in, const Image<float>& flow, float limit, Image<float>& out,
                WorkerPool& pool) {
  const int rows = in.rows(), cols = in.cols(), channels = in.channels();
  out.reshape_like(in);
  pool.for_rows(rows, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      const float* dx = flow.row(0, y);
      const float* dy = flow.row(1, y);
      for (int x = 0; x < cols; ++x) {
        const Position at(static_cast<float>(x) + dx[x], static_cast<float>(y) + dy[x], rows, cols);
        std::array<std::ptrdiff_t, 4> line, column;
        for (int k = 0; k < 4; ++k) {
          line[static_cast<std::size_t>(k)] =
              static_cast<std::ptrdiff_t>(std::clamp(at.y + k - 1, 0, rows - 1)) * cols;
          column[static_cast<std::size_t>(k)] = std::clamp(at.x + k - 1, 0, cols - 1);
        }
        if ((at.fx | at.fy) == 0) {
          for (int c = 0; c < channels; ++c) out.row(c, y)[x] = in.plane(c)[line[1] + column[1]];
          continue;
        }
        const Weights& wx = kCubic[static_cast<std::size_t>(at.fx)];
        const Weights& wy = kCubic[static_cast<std::size_t>(at.fy)];
        const float lx = static_cast<float>(at.fx) / kSubpixels, ly = static_cast<float>(at.fy) / kSubpixels;
        for (int c = 0; c < channels; ++c) {
          const float* plane = in.plane(c);
          float value = 0;
          for (std::size_t j = 0; j < 4; ++j) {
            const float* p = plane + line[j];
            value += wy[j] * (wx[0] * p[column[0]] + wx[1] * p[column[1]] + wx[2] * p[column[2]] +
                              wx[3] * p[column[3]]);
          }
          if (limit > 0) {
            const float *p = plane + line[1], *q = plane + line[2];
            const float top = p[column[1]] + lx * (p[column[2]] - p[column[1]]);
            const float bottom = q[column[1]] + lx * (q[column[2]] - q[column[1]]);
            const float linear = top + ly * (bottom - top);
            value = std::min(std::max(value, linear * (1 - limit)), linear * (1 + limit));
          }
          out.row(c, y)[x] = value;
        }
      }
    }
  });
}

void warp_linear(const Image<float>& in, const Image<float>& flow, Image<float>& out, WorkerPool& pool) {
  const int rows = in.rows(), cols = in.cols(), channels = in.channels();
  out.reshape_like(in);
  pool.for_rows(rows, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      const float* dx = flow.row(0, y);
      const float* dy = flow.row(1, y);
      for (int x = 0; x < cols; ++x) {
        const Position at(static_cast<float>(x) + dx[x], static_cast<float>(y) + dy[x], rows, cols);
        const std::ptrdiff_t line0 = static_cast<std::ptrdiff_t>(std::clamp(at.y, 0, rows - 1)) * cols;
        const std::ptrdiff_t line1 = static_cast<std::ptrdiff_t>(std::clamp(at.y + 1, 0, rows - 1)) * cols;
        const int c0 = std::clamp(at.x, 0, cols - 1), c1 = std::clamp(at.x + 1, 0, cols - 1);
        const float fx = static_cast<float>(at.fx) / kSubpixels, fy = static_cast<float>(at.fy) / kSubpixels;
        for (int c = 0; c < channels; ++c) {
          const float *p = in.plane(c) + line0, *q = in.plane(c) + line1;
          const float top = p[c0] + fx * (p[c1] - p[c0]), bottom = q[c0] + fx * (q[c1] - q[c0]);
          out.row(c, y)[x] = top + fy * (bottom - top);
        }
      }
    }
  });
}

}  // namespace hdrcam
