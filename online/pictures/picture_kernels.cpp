// Compiled once per instruction set into namespace HDRCAM_TARGET (see hdrcam_kernels() in CMakeLists.txt).
// Eight pixels are placed at once and then read from each channel; how depends on where they are.
#include "online/pictures/picture_kernels.h"

#include "hal/core/lane_functions.h"
#include "hal/core/picture_lanes.h"

namespace hdrcam::HDRCAM_TARGET {
namespace {

typedef float Quad __attribute__((vector_size(16), aligned(4), may_alias));

inline Quad load_quad(const float* p) { return *reinterpret_cast<const Quad*>(p); }
// Calls body(x, count, places) for a band, eight pixels at a time; `count` of them, fewer at a row's end.
template <class Body>
inline void across(const WarpBand& w, int y, Body&& body) {
  const std::ptrdiff_t line = static_cast<std::ptrdiff_t>(y) * w.cols;
  for (int x = 0; x < w.cols; x += kLanes) {
    const int count = least(w.cols - x, kLanes);
    const Lanes dx = load_some(w.dx + line + x, count), dy = load_some(w.dy + line + x, count);
    body(x, count, places(lanes(x + kEachLane) + dx, static_cast<float>(y) + dy, w.rows, w.cols));
  }
}

void warp_linear(const WarpBand& w) {
  const std::ptrdiff_t plane = static_cast<std::ptrdiff_t>(w.rows) * w.cols;
  for (int y = w.y0; y < w.y1; ++y)
    across(w, y, [&](int x, int count, const Places& at) {
      float* out = w.out + static_cast<std::ptrdiff_t>(y) * w.cols + x;
      read_between({w.in, w.channels, w.rows, w.cols}, at,
                   [&](int channel, Lanes value) { store_some(out + channel * plane, value, count); });
    });
}

// Catmull-Rom weights of the four pixels around a place, `f` beyond the second.
template <class V>
struct CubicWeights {
  V weight[4];
};
template <class V>
inline CubicWeights<V> cubic_weights(V f) {
  const V f2 = f * f, f3 = f2 * f;
  return {{-0.5f * f3 + f2 - 0.5f * f, 1.5f * f3 - 2.5f * f2 + 1, -1.5f * f3 + 2 * f2 + 0.5f * f,
           0.5f * f3 - 0.5f * f2}};
}

// Within what `limit` allows around the bilinear value.
template <class V>
inline V limited(V cubic, V linear, float limit) {
  return least(most(cubic, linear - limit), linear + limit);
}

// One pixel near the left or right border: the four of each row are a Quad.
[[gnu::noinline]] void read_cubic(const WarpBand& w, int x, int y, float fx, float fy, float* out,
                                  float* largest) {
  const std::ptrdiff_t plane = static_cast<std::ptrdiff_t>(w.rows) * w.cols;
  const auto [across_x] = cubic_weights(fx);
  const auto [down] = cubic_weights(fy);
  const Quad across_quad{across_x[0], across_x[1], across_x[2], across_x[3]};
  const Quad straight{0, 1 - fx, fx, 0};
  std::ptrdiff_t line[4];
  int column[4];
  for (int k = 0; k < 4; ++k) {
    line[k] = static_cast<std::ptrdiff_t>(clamped(y + k - 1, w.rows - 1)) * w.cols;
    column[k] = clamped(x + k - 1, w.cols - 1);
  }
  for (int channel = 0; channel < w.channels; ++channel) {
    const float* in = w.in + channel * plane;
    Quad p[4];
    for (int k = 0; k < 4; ++k) {
      const float* q = in + line[k];
      p[k] = Quad{q[column[0]], q[column[1]], q[column[2]], q[column[3]]};
    }
    const Quad cubic = across_quad * (down[0] * p[0] + down[1] * p[1] + down[2] * p[2] + down[3] * p[3]);
    float value = (cubic[0] + cubic[1]) + (cubic[2] + cubic[3]);
    if (w.limit > 0) {
      const Quad between = straight * (p[1] + fy * (p[2] - p[1]));
      value = limited(value, between[1] + between[2], w.limit);
    }
    out[channel * plane] = value;
    if (largest != nullptr) largest[channel * plane] = most(most(p[1][1], p[1][2]), most(p[2][1], p[2][2]));
  }
}

// What four neighbours of eight pixels hold, a lane a pixel. p: where a row begins; in [x, x + 4) each.
struct Fours {
  Lanes column[4];
};
inline Fours fours_in_a_row(const float* p) { return {{load(p), load(p + 1), load(p + 2), load(p + 3)}}; }
inline Fours fours_at(const float* p, Whole place) {
  const auto both = [&](int k) {
    return __builtin_shufflevector(load_quad(p + place[k]), load_quad(p + place[k + 4]), 0, 1, 2, 3, 4, 5, 6,
                                   7);
  };
  const Lanes a = both(0), b = both(1), c = both(2), d = both(3);
  const Lanes ab_low = __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13);
  const Lanes ab_high = __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15);
  const Lanes cd_low = __builtin_shufflevector(c, d, 0, 8, 1, 9, 4, 12, 5, 13);
  const Lanes cd_high = __builtin_shufflevector(c, d, 2, 10, 3, 11, 6, 14, 7, 15);
  return {{__builtin_shufflevector(ab_low, cd_low, 0, 1, 8, 9, 4, 5, 12, 13),
           __builtin_shufflevector(ab_low, cd_low, 2, 3, 10, 11, 6, 7, 14, 15),
           __builtin_shufflevector(ab_high, cd_high, 0, 1, 8, 9, 4, 5, 12, 13),
           __builtin_shufflevector(ab_high, cd_high, 2, 3, 10, 11, 6, 7, 14, 15)}};
}

// Eight pixels whose columns are all within the picture: the same sums as for one, a lane each. fours(in, k)
// reads row k of a plane.
template <class Rows>
inline void read_cubic_inside(const WarpBand& w, const Places& at, int count, float* out, float* largest,
                              Rows&& fours) {
  const std::ptrdiff_t plane = static_cast<std::ptrdiff_t>(w.rows) * w.cols;
  const auto [across_x] = cubic_weights(at.fx);
  const auto [down] = cubic_weights(at.fy);
  for (int channel = 0; channel < w.channels; ++channel) {
    const float* in = w.in + channel * plane;
    const Fours a = fours(in, 0), b = fours(in, 1), c = fours(in, 2), d = fours(in, 3);
    Lanes cubic[4];
    for (int k = 0; k < 4; ++k)
      cubic[k] = rounded(across_x[k] * (down[0] * a.column[k] + down[1] * b.column[k] +
                                        down[2] * c.column[k] + down[3] * d.column[k]));
    Lanes value = (cubic[0] + cubic[1]) + (cubic[2] + cubic[3]);
    if (w.limit > 0) {
      const auto middle = [&](int k) { return b.column[k] + at.fy * (c.column[k] - b.column[k]); };
      value = limited(value, rounded((1 - at.fx) * middle(1)) + rounded(at.fx * middle(2)), w.limit);
    }
    store_some(out + channel * plane, value, count);
    if (largest != nullptr)
      store_some(largest + channel * plane,
                 most(most(b.column[1], b.column[2]), most(c.column[1], c.column[2])), count);
  }
}

void log_radiance(const LogRadiance& l) {
  for (std::size_t i = 0; i < l.count; ++i) l.logarithm[i] = log_of(most(0.f, l.radiance[i]) + kDarkRadiance);
}

// A row of logarithms becomes radiance again; what does not move is copied.
void restore_radiance(const WarpBand& w, int y) {
  constexpr float kStill = 1.f / 64;  // pixels
  const std::ptrdiff_t line = static_cast<std::ptrdiff_t>(y) * w.cols,
                       plane = static_cast<std::ptrdiff_t>(w.rows) * w.cols;
  const float *dx = w.dx + line, *dy = w.dy + line;
  for (int channel = 0; channel < w.channels; ++channel) {
    const float* before = w.radiance + channel * plane + line;
    float* out = w.out + channel * plane + line;
    for (int x = 0; x < w.cols; ++x) {
      const float moved = most(0.f, exp_of(out[x]) - kDarkRadiance);
      const bool still = (dx[x] < kStill) & (dx[x] > -kStill) & (dy[x] < kStill) & (dy[x] > -kStill);
      out[x] = still ? before[x] : moved;
    }
  }
}

void warp_cubic(const WarpBand& w) {
  for (int y = w.y0; y < w.y1; ++y) {
    across(w, y, [&](int x, int count, const Places& at) {
      const std::ptrdiff_t place = static_cast<std::ptrdiff_t>(y) * w.cols + x;
      float* out = w.out + place;
      float* largest = w.largest != nullptr ? w.largest + place : nullptr;
      if (any_negative((at.x - 1) | (w.cols - 3 - at.x))) {
        for (int i = 0; i < count; ++i)
          read_cubic(w, at.x[i], at.y[i], at.fx[i], at.fy[i], out + i,
                     largest != nullptr ? largest + i : nullptr);
        return;
      }
      const auto row = [&](auto top, int k) { return clamped(top + (k - 1), w.rows - 1) * w.cols; };
      const Whole apart = (at.x - at.x[0] - kEachLane) | (at.y - at.y[0]);
      if (!any_negative(apart | -apart)) {
        const int left = at.x[0] - 1, top = at.y[0];
        const std::ptrdiff_t first[4] = {row(top, 0) + left, row(top, 1) + left, row(top, 2) + left,
                                         row(top, 3) + left};
        read_cubic_inside(w, at, count, out, largest,
                          [&](const float* in, int k) { return fours_in_a_row(in + first[k]); });
      } else {
        const Whole left = at.x - 1;
        const Whole first[4] = {row(at.y, 0) + left, row(at.y, 1) + left, row(at.y, 2) + left,
                                row(at.y, 3) + left};
        read_cubic_inside(w, at, count, out, largest,
                          [&](const float* in, int k) { return fours_at(in, first[k]); });
      }
    });
    if (w.radiance != nullptr) restore_radiance(w, y);
  }
}

inline int mirrored(int i, int n) {
  i = i < 0 ? -i : i;
  return clamped(i < n ? i : 2 * n - 2 - i, n - 1);
}

constexpr int kMostRadius = 2;
constexpr int kWide = 256;  // columns whose sums are at hand

// Sums over the lines of a window, for the columns from x0 on and kMostRadius more at either end.
struct ColumnSums {
  alignas(64) float sums[kWide + 2 * kMostRadius + kLanes];

  // Fills what a window of this radius reads for `count` columns; term(x, V{}) adds up column x.
  template <class Term>
  void fill(int x0, int count, int radius, int cols, Term&& term) {
    const int begin = x0 > radius ? x0 - radius : 0,
              end = x0 + count + radius < cols ? x0 + count + radius : cols;
    float* at = sums + kMostRadius - x0;  // at[x]: column x
    int x = begin;
    for (; x + kLanes <= end; x += kLanes) store(at + x, term(x, Lanes{}));
    for (; x < end; ++x) at[x] = term(x, 0.f);
    for (x = x0 - radius; x < begin; ++x) at[x] = at[mirrored(x, cols)];
    for (x = end; x < x0 + count + radius; ++x) at[x] = at[mirrored(x, cols)];
  }
  // of the window around the i-th column
  template <class V>
  V across(int i, int radius) const {
    const float* s = sums + kMostRadius + i;
    if (radius == 1) return get<V>(s - 1) + get<V>(s) + get<V>(s + 1);
    return (get<V>(s - 2) + get<V>(s - 1)) + get<V>(s) + (get<V>(s + 1) + get<V>(s + 2));
  }
};

template <int kRadius>
inline void mean_window(const WindowRow& w) {
  constexpr float kShare = 1.f / ((2 * kRadius + 1) * (2 * kRadius + 1));
  const float* const* l = w.line;
  ColumnSums columns;
  for (int x0 = 0; x0 < w.cols; x0 += kWide) {
    const int count = w.cols - x0 < kWide ? w.cols - x0 : kWide;
    columns.fill(x0, count, kRadius, w.cols, [&](int x, auto lane) {
      using V = decltype(lane);
      V sum = get<V>(l[0] + x) + get<V>(l[1] + x) + get<V>(l[2] + x);
      if constexpr (kRadius == 2) sum = sum + get<V>(l[3] + x) + get<V>(l[4] + x);
      return sum;
    });
    across(count, [&](int i, auto lane) {
      using V = decltype(lane);
      put<V>(w.mean + x0 + i, columns.across<V>(i, kRadius) * kShare);
    });
  }
}

void contrast_window(const WindowRow& w) {
  constexpr float kShare = 1 / 9.f;
  const float* const* l = w.line;
  ColumnSums columns, squares;
  for (int x0 = 0; x0 < w.cols; x0 += kWide) {
    const int count = w.cols - x0 < kWide ? w.cols - x0 : kWide;
    columns.fill(x0, count, 1, w.cols, [&](int x, auto lane) {
      using V = decltype(lane);
      return get<V>(l[0] + x) + get<V>(l[1] + x) + get<V>(l[2] + x);
    });
    squares.fill(x0, count, 1, w.cols, [&](int x, auto lane) {
      using V = decltype(lane);
      const V a = get<V>(l[0] + x), b = get<V>(l[1] + x), c = get<V>(l[2] + x);
      return a * a + b * b + c * c;
    });
    across(count, [&](int i, auto lane) {
      using V = decltype(lane);
      const V mean = columns.across<V>(i, 1) * kShare;
      put<V>(w.mean + x0 + i, mean);
      put<V>(w.variance + x0 + i, most(V{}, squares.across<V>(i, 1) * kShare - mean * mean));
    });
  }
}

void window(const WindowRow& w) {
  if (w.variance != nullptr) return contrast_window(w);
  w.radius == 1 ? mean_window<1>(w) : mean_window<2>(w);
}

}  // namespace

extern const PictureKernels kPictureKernels;
const PictureKernels kPictureKernels{&warp_linear, &warp_cubic, &log_radiance, &window};

}  // namespace hdrcam::HDRCAM_TARGET
