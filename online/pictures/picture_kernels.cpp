// Compiled once per instruction set into namespace HDRCAM_TARGET (see hdrcam_kernels() in CMakeLists.txt).
// A block of pixels is placed first (arithmetic), then each channel is read (memory).
#include "online/pictures/picture_kernels.h"

namespace hdrcam::HDRCAM_TARGET {
namespace {

typedef float Quad __attribute__((vector_size(16), aligned(4), may_alias));

inline Quad load(const float* p) { return *reinterpret_cast<const Quad*>(p); }
inline int clamped(int v, int most) { return v > 0 ? (v < most ? v : most) : 0; }
inline float least(float a, float b) { return a < b ? a : b; }
inline float most(float a, float b) { return a > b ? a : b; }

constexpr int kSubpixels = 32, kBlock = 64;

// Positions of a block of pixels, split into whole pixels and 1/32 pixels.
struct Places {
  alignas(64) int x[kBlock], y[kBlock];
  alignas(64) float fx[kBlock], fy[kBlock];
};

inline void place(const WarpBand& w, int y, int x0, int count, Places& at) {
  // far outside or not finite: the border; keeps the integer conversion defined, and positive before the cut
  constexpr int kOutside = 4;
  const float limit_x = static_cast<float>(w.cols + kOutside),
              limit_y = static_cast<float>(w.rows + kOutside);
  const std::ptrdiff_t line = static_cast<std::ptrdiff_t>(y) * w.cols + x0;
  const float *dx = w.dx + line, *dy = w.dy + line;
  for (int i = 0; i < count; ++i) {
    float px = static_cast<float>(x0 + i) + dx[i], py = static_cast<float>(y) + dy[i];
    px = px > -kOutside ? (px < limit_x ? px : limit_x) : -kOutside;
    py = py > -kOutside ? (py < limit_y ? py : limit_y) : -kOutside;
    const int qx = static_cast<int>((px + kOutside) * kSubpixels + 0.5f);
    const int qy = static_cast<int>((py + kOutside) * kSubpixels + 0.5f);
    at.x[i] = qx / kSubpixels - kOutside, at.y[i] = qy / kSubpixels - kOutside;
    at.fx[i] = static_cast<float>(qx % kSubpixels) / kSubpixels;
    at.fy[i] = static_cast<float>(qy % kSubpixels) / kSubpixels;
  }
}

void warp_linear(const WarpBand& w) {
  const std::ptrdiff_t plane = static_cast<std::ptrdiff_t>(w.rows) * w.cols;
  Places at;
  alignas(64) int a[kBlock], b[kBlock], c[kBlock], d[kBlock];  // where the four pixels around a place are
  for (int y = w.y0; y < w.y1; ++y)
    for (int x0 = 0; x0 < w.cols; x0 += kBlock) {
      const int count = w.cols - x0 < kBlock ? w.cols - x0 : kBlock;
      place(w, y, x0, count, at);
      for (int i = 0; i < count; ++i) {
        const int above = clamped(at.y[i], w.rows - 1) * w.cols,
                  below = clamped(at.y[i] + 1, w.rows - 1) * w.cols;
        const int left = clamped(at.x[i], w.cols - 1), right = clamped(at.x[i] + 1, w.cols - 1);
        a[i] = above + left, b[i] = above + right, c[i] = below + left, d[i] = below + right;
      }
      for (int channel = 0; channel < w.channels; ++channel) {
        const float* __restrict in = w.in + channel * plane;
        float* __restrict out = w.out + channel * plane + static_cast<std::ptrdiff_t>(y) * w.cols + x0;
        for (int i = 0; i < count; ++i) {
          const float top = in[a[i]] + at.fx[i] * (in[b[i]] - in[a[i]]);
          const float bottom = in[c[i]] + at.fx[i] * (in[d[i]] - in[c[i]]);
          out[i] = top + at.fy[i] * (bottom - top);
        }
      }
    }
}

// Catmull-Rom weights of the four pixels around a place, `f` beyond the second.
inline Quad cubic_weights(float f) {
  const float f2 = f * f, f3 = f2 * f;
  return Quad{-0.5f * f3 + f2 - 0.5f * f, 1.5f * f3 - 2.5f * f2 + 1, -1.5f * f3 + 2 * f2 + 0.5f * f,
              0.5f * f3 - 0.5f * f2};
}

void warp_cubic(const WarpBand& w) {
  const std::ptrdiff_t plane = static_cast<std::ptrdiff_t>(w.rows) * w.cols;
  Places at;
  for (int y = w.y0; y < w.y1; ++y)
    for (int x0 = 0; x0 < w.cols; x0 += kBlock) {
      const int count = w.cols - x0 < kBlock ? w.cols - x0 : kBlock;
      place(w, y, x0, count, at);
      for (int i = 0; i < count; ++i) {
        const int x = at.x[i], top = at.y[i];
        const float fx = at.fx[i], fy = at.fy[i];
        const Quad across = cubic_weights(fx), down = cubic_weights(fy);
        const Quad straight{0, 1 - fx, fx, 0};
        const bool within = x >= 1 && x + 2 < w.cols;
        std::ptrdiff_t line[4];
        for (int k = 0; k < 4; ++k)
          line[k] = static_cast<std::ptrdiff_t>(clamped(top + k - 1, w.rows - 1)) * w.cols;
        const int column[4] = {clamped(x - 1, w.cols - 1), clamped(x, w.cols - 1), clamped(x + 1, w.cols - 1),
                               clamped(x + 2, w.cols - 1)};
        float* out = w.out + static_cast<std::ptrdiff_t>(y) * w.cols + x0 + i;
        for (int channel = 0; channel < w.channels; ++channel) {
          const float* in = w.in + channel * plane;
          Quad p[4];
          for (int k = 0; k < 4; ++k) {
            const float* q = in + line[k];
            p[k] = within ? load(q + x - 1) : Quad{q[column[0]], q[column[1]], q[column[2]], q[column[3]]};
          }
          const Quad cubic = across * (down[0] * p[0] + down[1] * p[1] + down[2] * p[2] + down[3] * p[3]);
          float value = (cubic[0] + cubic[1]) + (cubic[2] + cubic[3]);
          if (w.limit > 0) {
            const Quad between = straight * (p[1] + fy * (p[2] - p[1]));
            const float linear = between[1] + between[2];
            value = least(most(value, linear * (1 - w.limit)), linear * (1 + w.limit));
          }
          out[channel * plane] = value;
        }
      }
    }
}

inline int mirrored(int i, int n) {
  i = i < 0 ? -i : i;
  return clamped(i < n ? i : 2 * n - 2 - i, n - 1);
}

constexpr int kMostRadius = 2;

// Sums over the columns around x0 .. x0 + count of what term(x) adds up from a column; `sums` needs
// kMostRadius more at either end.
template <class Term>
inline void sum_columns(int x0, int count, int radius, int cols, float* sums, Term&& term, float* out) {
  const int begin = x0 > radius ? x0 - radius : 0,
            end = x0 + count + radius < cols ? x0 + count + radius : cols;
  float* at = sums + kMostRadius - x0;  // at[x]: column x
  for (int x = begin; x < end; ++x) at[x] = term(x);
  for (int x = x0 - radius; x < begin; ++x) at[x] = at[mirrored(x, cols)];
  for (int x = end; x < x0 + count + radius; ++x) at[x] = at[mirrored(x, cols)];
  const float* s = sums + kMostRadius;
  if (radius == 1)
    for (int i = 0; i < count; ++i) out[i] = s[i - 1] + s[i] + s[i + 1];
  else
    for (int i = 0; i < count; ++i) out[i] = (s[i - 2] + s[i - 1]) + s[i] + (s[i + 1] + s[i + 2]);
}

void window(const WindowRow& w) {
  constexpr int kWide = 256;  // columns at a time
  alignas(64) float sums[kWide + 2 * kMostRadius], total[kWide], squares[kWide];
  const float* l[2 * kMostRadius + 1];  // the rows around y, from above to below
  for (int k = 0; k <= 2 * w.radius; ++k)
    l[k] = w.plane + static_cast<std::ptrdiff_t>(mirrored(w.y + k - w.radius, w.rows)) * w.cols;
  const float share = 1.f / static_cast<float>((2 * w.radius + 1) * (2 * w.radius + 1));
  for (int x0 = 0; x0 < w.cols; x0 += kWide) {
    const int count = w.cols - x0 < kWide ? w.cols - x0 : kWide;
    float* __restrict mean = w.mean + x0;
    if (w.radius == 1)
      sum_columns(
          x0, count, 1, w.cols, sums, [&](int x) { return l[0][x] + l[1][x] + l[2][x]; }, total);
    else
      sum_columns(
          x0, count, 2, w.cols, sums, [&](int x) { return l[0][x] + l[1][x] + l[2][x] + l[3][x] + l[4][x]; },
          total);
    for (int i = 0; i < count; ++i) mean[i] = total[i] * share;
    if (w.variance == nullptr) continue;
    sum_columns(
        x0, count, 1, w.cols, sums,
        [&](int x) { return l[0][x] * l[0][x] + l[1][x] * l[1][x] + l[2][x] * l[2][x]; }, squares);
    float* __restrict variance = w.variance + x0;
    for (int i = 0; i < count; ++i) variance[i] = most(0, squares[i] * share - mean[i] * mean[i]);
  }
}

}  // namespace

extern const PictureKernels kPictureKernels;
const PictureKernels kPictureKernels{&warp_linear, &warp_cubic, &window};

}  // namespace hdrcam::HDRCAM_TARGET
