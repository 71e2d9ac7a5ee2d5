// Compiled once per instruction set into namespace HDRCAM_TARGET (see hdrcam_kernels() in CMakeLists.txt).
// demosaic.h says what the passes mean.
#include "capture/demosaic_kernels.h"

#include "hal/core/lanes.h"

namespace hdrcam::HDRCAM_TARGET {
namespace {

constexpr int kBlock = 64;  // pixels, an even number

// A stretch of a row with some columns on either side.
template <int kSides>
struct Stretch {
  alignas(64) float values[kBlock + 2 * kSides];

  // Columns [x0 - kSides, x0 + count + kSides) of n: of(column), mirrored about the border pixels.
  template <class Of>
  void fill(int x0, int count, int n, Of&& of) {
    const int from = x0 - kSides, to = x0 + count + kSides;
    if (from >= 0 && to <= n) {
      for (int i = 0; i < to - from; ++i) values[i] = of(from + i);
      return;
    }
    for (int i = 0; i < to - from; ++i) {
      int x = from + i;
      x = x < 0 ? -x : x;
      x = x >= n ? 2 * (n - 1) - x : x;
      values[i] = of(x < 0 ? 0 : (x >= n ? n - 1 : x));
    }
  }
  template <class V>
  V at(int i) const {
    return get<V>(values + kSides + i);
  }
};

template <class V>
inline V magnitude(V v) {
  return most(v, -v);
}

// Whether columns from x, which is even for lanes, are odd: 0 or 1.
inline float oddness(int x, float) { return static_cast<float>(x & 1); }
inline Lanes oddness(int, Lanes) { return Lanes{0, 1, 0, 1, 0, 1, 0, 1}; }

// One line through a red or blue pixel: the two greens beside it and the two samples of its own colour beyond
// them.
template <class V>
struct Line {
  V gradient, green;
};
template <class V>
inline Line<V> along(V far_before, V green_before, V own, V green_after, V far_after) {
  const V bend = 2 * own - far_before - far_after;
  // The curvature of the sampled colour sharpens the green, limited to the range of the neighbouring greens:
  // beside a clipped region it would ring otherwise.
  const V sharpened = (green_before + green_after) * 0.5f + bend * 0.25f;
  const V low = least(green_before, green_after), high = most(green_before, green_after);
  return {magnitude(green_before - green_after) + magnitude(bend), least(most(sharpened, low), high)};
}

void green(const GreenRow& row, int n) {
  const auto lacking = static_cast<float>(row.lacking);
  for (int x0 = 0; x0 < n; x0 += kBlock) {
    const int count = n - x0 < kBlock ? n - x0 : kBlock;
    Stretch<2> near[5];
    for (int r = 0; r < 5; ++r) {
      const std::uint16_t* __restrict codes = row.mosaic[r];
      near[r].fill(x0, count, n, [=](int x) { return static_cast<float>(codes[x]); });
    }
    across(count, [&](int i, auto lane) {
      using V = decltype(lane);
      const Stretch<2>& here = near[2];
      const V own = here.at<V>(i);
      const Line<V> level =
          along(here.at<V>(i - 2), here.at<V>(i - 1), own, here.at<V>(i + 1), here.at<V>(i + 2));
      const Line<V> upright =
          along(near[0].at<V>(i), near[1].at<V>(i), own, near[3].at<V>(i), near[4].at<V>(i));
      const V neither = (level.green + upright.green) * 0.5f;
      V found = upright.gradient < level.gradient ? upright.green : neither;
      found = level.gradient < upright.gradient ? level.green : found;
      put<V>(row.green + x0 + i, oddness(i, lane) == lacking ? found : own);
    });
  }
}

void colour(const ColourRow& row, int n) {
  const auto having = static_cast<float>(row.having);
  for (int x0 = 0; x0 < n; x0 += kBlock) {
    const int count = n - x0 < kBlock ? n - x0 : kBlock;
    Stretch<1> difference[3];
    const int first = row.is_in_row ? 1 : 0, step = row.is_in_row ? 1 : 2;
    for (int r = first; r < 3 - first; r += step) {
      const std::uint16_t* __restrict codes = row.mosaic[r];
      const float* __restrict greens = row.green[r];
      difference[r].fill(x0, count, n, [=](int x) { return static_cast<float>(codes[x]) - greens[x]; });
    }
    const auto finish = [&](int i, auto value) {
      put(row.out + x0 + i, clamped(value, 0, row.most) * row.scale);
    };
    if (row.is_in_row) {
      across(count, [&](int i, auto lane) {
        using V = decltype(lane);
        const Stretch<1>& here = difference[1];
        const V beside = (here.at<V>(i - 1) + here.at<V>(i + 1)) * 0.5f;
        finish(i, get<V>(row.green[1] + x0 + i) + (oddness(i, lane) == having ? here.at<V>(i) : beside));
      });
      continue;
    }
    across(count, [&](int i, auto lane) {
      using V = decltype(lane);
      const Stretch<1>&above = difference[0], &below = difference[2];
      const V between = (above.at<V>(i) + below.at<V>(i)) * 0.5f;
      // of the two diagonals, the one along which the difference changes less
      const V a = above.at<V>(i - 1), b = below.at<V>(i + 1), c = above.at<V>(i + 1), d = below.at<V>(i - 1);
      const V falling = magnitude(a - b), rising = magnitude(c - d), ab = a + b, cd = c + d;
      V diagonal = rising < falling ? cd * 0.5f : (ab + cd) * 0.25f;
      diagonal = falling < rising ? ab * 0.5f : diagonal;
      finish(i, get<V>(row.green[1] + x0 + i) + (oddness(i, lane) == having ? between : diagonal));
    });
  }
}

}  // namespace

extern const DemosaicKernels kDemosaicKernels;
const DemosaicKernels kDemosaicKernels = {green, colour};

}  // namespace hdrcam::HDRCAM_TARGET
