// Compiled once per instruction set into namespace HDRCAM_TARGET (see hdrcam_kernels() in CMakeLists.txt).
// fusion.h says what the passes mean.
#include "online/state/fusion_kernels.h"

#include "capture/clip_policy.h"
#include "hal/core/lane_functions.h"
#include "hal/core/picture_lanes.h"
#include "online/state/pass_constants.h"

namespace hdrcam::HDRCAM_TARGET {
namespace {

using namespace pass_constants;

constexpr int kBlock = 64;  // pixels; tables are looked up in a loop of its own, which then is a gather

// Calls body(first, count) for one block of a row after the other.
template <class Body>
inline void in_blocks(int n, Body&& body) {
  for (int x0 = 0; x0 < n; x0 += kBlock) body(x0, n - x0 < kBlock ? n - x0 : kBlock);
}
// For a block of pixels of this radiance.
inline void variances_of(const SampleVariances& noise, const float* __restrict radiance, int n,
                         float* __restrict variance) {
  alignas(64) int place[kBlock];
  for (int i = 0; i < n; ++i)
    place[i] = static_cast<int>(__builtin_sqrtf(clamped(radiance[i] * noise.exposure, 0, 1)) * kSegments);
  for (int i = 0; i < n; ++i) variance[i] = noise.table[place[i]];
}

// Calls body(x, noise) for all n pixels; noise, Lanes or float, is the variance of a sample where the
// radiance is `mean`.
template <class Body>
inline void across_noise(const SampleVariances& noise, const float* mean, int n, Body&& body) {
  in_blocks(n, [&](int x0, int count) {
    alignas(64) float variance[kBlock];
    variances_of(noise, mean + x0, count, variance);
    across(count, [&](int i, auto lane) { body(x0 + i, get<decltype(lane)>(variance + i)); });
  });
}

inline float root(float v) { return __builtin_sqrtf(v); }

// A table between its entries; the two that it needs come together.
inline float table_at(const float* table, float place) {
  const int z = static_cast<int>(place);
  return table[z] + (table[z + 1] - table[z]) * (place - static_cast<float>(z));
}
inline Lanes table_at(const float* table, Lanes place) {
  const Whole z = whole(place);
  const PixelPairs entries = pairs_at(table, z);
  return entries.left + (entries.right - entries.left) * (place - lanes(z));
}

void sample(const SampledRow& row, int n) {
  using namespace clip_policy;
  across(n, [&](int x, auto lane) {
    using V = decltype(lane);
    const V code = get<V>(row.codes + x), bright = most(code, get<V>(row.brightest + x));
    put<V>(row.weight + x, 1 - smooth_step(kFadeBegin, kFadeEnd, bright));
    put<V>(row.comparable + x, (1 - smooth_step(kCompareFadeBegin, kCompareFadeEnd, bright)) *
                                   smooth_step(kCompareDarkBegin, kCompareDarkEnd, code));
    put<V>(row.radiance + x, table_at(row.radiances, clamped(code, 0, 255)));
  });
}

void record(const RecordedRow& row, int n) {
  across(n, [&](int x, auto lane) {
    using V = decltype(lane);
    V sum{};
    for (int c = 0; c < 3; ++c) {
      V seen = get<V>(row.radiance[c] + x);
      if (row.blur[c] != nullptr) seen += get<V>(row.blur[c] + x);
      sum += table_at(row.codes[c], root(clamped(seen * row.exposure, 0, 1)) * kSegments);
    }
    put<V>(row.gray + x, sum * (1 / 3.f));
  });
}

void stand_in(const StandInRow& row, int n) {
  across(n, [&](int x, auto lane) {
    using V = decltype(lane);
    const V state = get<V>(row.state + x), sample = get<V>(row.sample + x);
    put<V>(row.out + x, get<V>(row.variance + x) < row.unseen_from ? state : sample);
  });
}

void compare(const ComparedRow& row, int n) {
  across_noise(row.noise, row.mean, n, [&](int x, auto noise) {
    using V = decltype(noise);
    const V s = get<V>(row.state + x), v = get<V>(row.variance + x), r = get<V>(row.sample + x);
    const V blur = row.blur != nullptr ? get<V>(row.blur + x) : V{};
    const V mask = v < row.unseen_from ? get<V>(row.comparable + x) : V{};
    const V off = s + blur - r, average = 0.5f * (s + r);
    const V allowed = v + noise + row.relative2 * average * average +
                      row.texture2 * get<V>(row.contrast + x) + row.blur_tolerance * blur * blur + kTiny;
    put(row.chi2 + x, get<V>(row.chi2 + x) + mask * off * off / allowed);
    put(row.covered + x, get<V>(row.covered + x) + mask);
  });
}

void gate(const GatedRow& row, int n) {
  const float scale = 1 / row.scale, open = 1 - row.floor;
  in_blocks(n, [&](int x0, int count) {
    alignas(64) float agrees[kBlock], bounded[kBlock];  // logarithms
    across(count, [&](int i, auto lane) {
      using V = decltype(lane);
      const int x = x0 + i;
      const V excess = get<V>(row.chi2 + x) / (get<V>(row.covered + x) + kHardlyCompared) - row.tolerance;
      put(agrees + i, -scale * most(excess, V{}));
      // a clipped sample is a lower bound; a darker state does not show the same surface
      V below{};
      for (int c = 0; c < 3; ++c) {
        const V ratio = get<V>(row.state[c] + x) / (kBound * get<V>(row.sample[c] + x) + kTiny);
        const V under = (1 - ratio) / kBelowBound;
        below = most(get<V>(row.weight[c] + x) < kClipped ? under : V{}, below);
      }
      put(bounded + i, -below * below);
    });
    for (int i = 0; i < count; ++i) agrees[i] = exp_of(agrees[i]);
    for (int i = 0; i < count; ++i) bounded[i] = exp_of(bounded[i]);
    across(count, [&](int i, auto lane) {
      using V = decltype(lane);
      const int x = x0 + i;
      const V agreement = 1 - least(all<V>(1), get<V>(row.covered + x)) * open * (1 - get<V>(agrees + i));
      put(row.gate + x, get<V>(row.trust + x) * agreement * (row.floor + open * get<V>(bounded + i)));
    });
  });
}

// The variance of what is only guessed to be there, a surface that may be another one: its own size. A dark
// code knows less than that, and must not take the place of what was seen next to it.
template <class V>
inline V guessed(V state, V sample, float least_radiance) {
  const V size = most(most(state, sample), all<V>(least_radiance));
  return size * size;
}

// Compression and sharpening leave codes below white in what is clipped: where the state, as this exposure
// sees it, is surely beyond white, codes that fade already count less.
template <class V>
inline V without_ringing(const UpdatedRow& row, V seen, V variance, V weight) {
  const V sure = variance < row.unseen_from ? seen - kSureSigmas * root(variance) : seen;
  const V clipped = smooth_step(kSurelyClipped, kFarClipped, sure * row.noise.exposure);
  return most(weight - row.ringing * kRingingFades * clipped * (1 - weight), V{});
}

// What a frame shows clipped is so bright that one exposed longer clips it, too; what that shows much darker
// is something else, as behind a flash.
template <class V>
inline auto shows_else(const UpdatedRow& row, V state, V variance, V sample) {
  const float white = 1 / row.noise.exposure;
  return (variance >= row.unseen_from) & (state >= kAtClip * white) & (sample < kElse * white);
}

inline bool some(bool is) { return is; }
inline bool some(Whole are) { return any_negative(are); }

void update(const UpdatedRow& row, int n) {
  across_noise(row.noise, row.mean, n, [&](int x, auto noise) {
    using V = decltype(noise);
    const V s = get<V>(row.state + x), r = get<V>(row.sample + x);
    const V blur = row.blur != nullptr ? get<V>(row.blur + x) : V{}, blur2 = blur * blur;
    const V held = get<V>(row.variance + x);
    V v = held, weighs = get<V>(row.weight + x), counts_below = all<V>(row.unseen_from);
    if (row.ringing > 0 && some((weighs > 0) & (weighs < 1)))
      weighs = without_ringing(row, s + blur, held, weighs);
    if (!row.starts) {
      const V guess = weighs < kClipped ? v : least(v, guessed(s, r, row.least));
      v = v < row.unseen_from ? v : guess;
    }
    if (row.bounded && some(held >= row.unseen_from)) {
      const auto other = shows_else(row, s, held, r);
      weighs = other ? V{} : weighs, counts_below = other ? V{} : counts_below;
      v = other ? held : v;  // it stays a bound, which the next frame must not take for something seen
    }
    const V mean = get<V>(row.mean + x), mean2 = mean * mean;
    const V sharp = most(r - blur * blur2 / (blur2 + v + kTiny), V{});
    const V taken = v < row.unseen_from ? sharp : r;
    const V blur_doubt = v < row.unseen_from ? all<V>(row.blur_variance) : all<V>(row.unknown_blur_variance);
    V doubt = noise + row.relative2 * mean2 + blur_doubt * blur2;
    if (row.extra != nullptr) doubt += get<V>(row.extra + x);
    if (row.gate != nullptr) weighs *= get<V>(row.gate + x);
    // the inverse variances' sum, with one division: of the sample 1 / doubt, as far as it is weighed
    const V per_both = 1 / (doubt + v * weighs + kTiny), part = v * weighs * per_both;
    // what no frame saw unclipped keeps the larger of the bounds
    const auto counts = (v < counts_below) | (weighs * mean2 > kLeastSignal2 * doubt);
    put<V>(row.new_state + x, counts ? s + (taken - s) * part : most(s, r));
    put<V>(row.new_variance + x, counts ? doubt * (v * per_both) : v);
    put<V>(row.share + x, get<V>(row.share + x) + (counts ? part * (1 / 3.f) : V{}));
  });
}

void doubt_textures(const TexturedRow& row, int n) {
  across_noise(row.hidden, row.mean, n, [&](int x, auto most) {
    const auto contrast = get<decltype(most)>(row.doubt + x);
    put(row.doubt + x, row.share * contrast + contrast * most / (contrast + most + kTiny));
  });
}

// The fraction of a pixel, of an ordinary number.
inline float beyond(float v) {
  const float f = v - static_cast<float>(static_cast<int>(v));
  return f + (f < 0 ? 1 : 0);
}
inline Lanes beyond(Lanes v) {
  const Lanes f = v - lanes(whole(v));
  return f < 0 ? f + 1 : f;
}

void warp_variance(const WarpedRow& row, int n) {
  constexpr float kFar = 1e6f;  // pixels
  in_blocks(n, [&](int x0, int count) {
    alignas(64) float length[kBlock];
    const float* __restrict dx = row.dx + x0, * __restrict dy = row.dy + x0;
    for (int i = 0; i < count; ++i) length[i] = __builtin_sqrtf(dx[i] * dx[i] + dy[i] * dy[i]);
    across(count, [&](int i, auto lane) {
      using V = decltype(lane);
      const V fx = beyond(clamped(get<V>(dx + i), -kFar, kFar));
      const V fy = beyond(clamped(get<V>(dy + i), -kFar, kFar));
      const V between = 2 * (fx * (1 - fx) + fy * (1 - fy));
      const V moving = least(all<V>(1), get<V>(length + i));
      put<V>(row.per_contrast + x0 + i, row.scale * (kByMotion * moving + kByInterpolation * between));
    });
  });
}

void age(const AgedRow& row, int n) {
  across(n, [&](int x, auto lane) {
    using V = decltype(lane);
    const V s = get<V>(row.state + x), gate = get<V>(row.gate + x);
    const V aged = get<V>(row.variance + x) * row.growth + row.relative2 * s * s +
                   get<V>(row.per_contrast + x) * get<V>(row.contrast + x);
    const V lost_variance = all<V>(row.lost_variance), doubted = aged / most(gate, all<V>(kLeastGate));
    V lost = doubted < row.lost_variance ? doubted : lost_variance;
    lost = gate <= row.floor ? lost_variance : lost;
    const V guess =
        aged < row.unseen_from ? most(aged, guessed(s, get<V>(row.sample + x), row.least)) : lost_variance;
    put<V>(row.new_variance + x, get<V>(row.weight + x) < kClipped ? lost : least(lost, guess));
  });
}

}  // namespace

extern const FusionKernels kFusionKernels;
const FusionKernels kFusionKernels{&sample, &record,         &stand_in,      &compare, &gate,
                                   &update, &doubt_textures, &warp_variance, &age};

}  // namespace hdrcam::HDRCAM_TARGET
