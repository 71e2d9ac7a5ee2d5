// Eight places of a picture read at once, for the kernels that are compiled once per instruction set. Where
// pictures move, neighbours mostly show neighbours: one load then reads what eight would, and elsewhere the
// two pixels that an interpolation needs of a row come together; both are faster than a gather and give the
// same bits. Internal linkage, as for lanes.h.
#pragma once

#if defined(__aarch64__)
#include <arm_neon.h>
#endif

#include <cstddef>

#include "hal/core/lanes.h"
#include "hal/core/subpixels.h"

namespace hdrcam::HDRCAM_TARGET {
namespace {

typedef int Whole __attribute__((vector_size(kLanes * sizeof(int)), aligned(sizeof(int)), may_alias));
constexpr Whole kEachLane{0, 1, 2, 3, 4, 5, 6, 7};

[[maybe_unused]] inline Whole whole(Lanes v) { return __builtin_convertvector(v, Whole); }
[[maybe_unused]] inline Lanes lanes(Whole v) { return __builtin_convertvector(v, Lanes); }

[[maybe_unused]] inline bool any_negative(Whole v) {
#if defined(__AVX__)
  return __builtin_ia32_movmskps256((Lanes)v) != 0;
#elif defined(__aarch64__)
  return vminvq_s32(__builtin_shufflevector(v, v, 0, 1, 2, 3) | __builtin_shufflevector(v, v, 4, 5, 6, 7)) <
         0;
#else
  return (v[0] | v[1] | v[2] | v[3] | v[4] | v[5] | v[6] | v[7]) < 0;
#endif
}
// Whether the places follow one another.
[[maybe_unused]] inline bool in_a_row(Whole place) {
  const Whole apart = place - place[0] - kEachLane;
  return !any_negative(apart | -apart);
}

[[maybe_unused]] inline Lanes root(Lanes v) {
#if defined(__AVX__)
  return __builtin_ia32_sqrtps256(v);
#elif defined(__aarch64__)
  const auto low = vsqrtq_f32(__builtin_shufflevector(v, v, 0, 1, 2, 3));
  return __builtin_shufflevector(low, vsqrtq_f32(__builtin_shufflevector(v, v, 4, 5, 6, 7)), 0, 1, 2, 3, 4, 5,
                                 6, 7);
#else
  for (int k = 0; k < kLanes; ++k) v[k] = __builtin_sqrtf(v[k]);
  return v;
#endif
}

// A product that is rounded before it is added to, on every target: no compiler makes one operation of both.
[[maybe_unused]] inline Lanes rounded(Lanes v) {
#if defined(__AVX__)
  __asm__("" : "+x"(v));
#elif defined(__aarch64__)
  typedef float Quad __attribute__((vector_size(16)));
  Quad low = __builtin_shufflevector(v, v, 0, 1, 2, 3), high = __builtin_shufflevector(v, v, 4, 5, 6, 7);
  __asm__("" : "+w"(low), "+w"(high));
  v = __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
#endif
  return v;
}

// The first `count` of eight; the others are zero.
[[maybe_unused]] inline Lanes load_some(const float* p, int count) {
  if (count >= kLanes) return load(p);
  Lanes v{};
  for (int k = 0; k < count; ++k) v[k] = p[k];
  return v;
}
[[maybe_unused]] inline void store_some(float* p, Lanes v, int count) {
  if (count >= kLanes) return store(p, v);
  for (int k = 0; k < count; ++k) p[k] = v[k];
}

// Eight pixels, each at a place of its own.
[[maybe_unused]] inline Lanes lanes_at(const float* p, Whole place) {
  return Lanes{p[place[0]], p[place[1]], p[place[2]], p[place[3]],
               p[place[4]], p[place[5]], p[place[6]], p[place[7]]};
}

// The pixels that are nearest to eight places of a picture, which may be outside.
struct Nearest {
  Whole place;
  bool together;  // one after the other
};
[[maybe_unused]] inline Nearest nearest(Lanes x, Lanes y, int rows, int cols) {
  const float right = static_cast<float>(cols - 1), bottom = static_cast<float>(rows - 1);
  const Whole column = whole(clamped(x, 0, right) + 0.5f), row = whole(clamped(y, 0, bottom) + 0.5f);
  const Whole place = row * cols + column;
  return {place, in_a_row(place)};
}
[[maybe_unused]] inline Lanes read(const float* p, const Nearest& at) {
  return at.together ? load(p + at.place[0]) : lanes_at(p, at.place);
}

// A pixel and its right neighbour, at eight places.
struct PixelPairs {
  Lanes left, right;
};
[[maybe_unused]] inline PixelPairs pairs_at(const float* p, Whole place) {
  typedef double Couple __attribute__((aligned(sizeof(float)), may_alias));
  typedef double Couples __attribute__((vector_size(32), may_alias));
  const auto at = [&](int k) { return *reinterpret_cast<const Couple*>(p + place[k]); };
  const Lanes outer = (Lanes)Couples{at(0), at(1), at(4), at(5)};
  const Lanes inner = (Lanes)Couples{at(2), at(3), at(6), at(7)};
  return {__builtin_shufflevector(outer, inner, 0, 2, 8, 10, 4, 6, 12, 14),
          __builtin_shufflevector(outer, inner, 1, 3, 9, 11, 5, 7, 13, 15)};
}

// Between four pixels; one formula for all who interpolate, so that they agree to the bit.
[[maybe_unused]] inline Lanes between(PixelPairs above, PixelPairs below, Lanes fx, Lanes fy) {
  const Lanes top = above.left + fx * (above.right - above.left);
  const Lanes bottom = below.left + fx * (below.right - below.left);
  return top + fy * (bottom - top);
}
// Where the pixels to the upper left are: in a row from `p` on, or each at its place. Their neighbours to the
// right and below are within the picture.
[[maybe_unused]] inline Lanes between_in_a_row(const float* p, std::ptrdiff_t pitch, Lanes fx, Lanes fy) {
  return between({load(p), load(p + 1)}, {load(p + pitch), load(p + pitch + 1)}, fx, fy);
}
[[maybe_unused]] inline Lanes between_at(const float* p, std::ptrdiff_t pitch, Whole place, Lanes fx,
                                         Lanes fy) {
  return between(pairs_at(p, place), pairs_at(p + pitch, place), fx, fy);
}

[[maybe_unused]] inline int clamped(int v, int most) { return v > 0 ? (v < most ? v : most) : 0; }
[[maybe_unused]] inline Whole clamped(Whole v, int most) {
  v = v > 0 ? v : Whole{};
  return v < most ? v : Whole{} + most;
}

// Positions of eight pixels, split into whole pixels and 1/32 pixels.
struct Places {
  Whole x, y;
  Lanes fx, fy;
};

// Along one axis.
[[maybe_unused]] inline void place(Lanes at, int size, Whole& pixel, Lanes& fraction) {
  // far outside or not finite: the border; keeps the integer conversion defined, and positive before the cut
  using subpixels::kOutside, subpixels::kShift, subpixels::kSubpixels;
  const float limit = static_cast<float>(size + kOutside);
  at = at > -kOutside ? (at < limit ? at : all<Lanes>(limit)) : all<Lanes>(-kOutside);
  const Whole q = whole((at + kOutside) * kSubpixels + 0.5f);
  pixel = (q >> kShift) - kOutside;
  fraction = lanes(q & (kSubpixels - 1)) / kSubpixels;
}

// In a picture of this size.
[[maybe_unused]] inline Places places(Lanes x, Lanes y, int rows, int cols) {
  Places at;
  place(x, cols, at.x, at.fx);
  place(y, rows, at.y, at.fy);
  return at;
}

// [channels, rows, cols] of floats.
struct Planes {
  const float* first;
  int channels, rows, cols;
};

// Where neighbours may be missing: the border's pixels stand in for them. Kept out of the loop over all
// pixels, which is longer with it.
[[maybe_unused]] [[gnu::noinline]] Lanes read_at_border(const Planes& in, int channel, const Places& at) {
  const float* p = in.first + static_cast<std::ptrdiff_t>(channel) * in.rows * in.cols;
  const Whole above = clamped(at.y, in.rows - 1) * in.cols, below = clamped(at.y + 1, in.rows - 1) * in.cols;
  const Whole left = clamped(at.x, in.cols - 1), right = clamped(at.x + 1, in.cols - 1);
  return between({lanes_at(p, above + left), lanes_at(p, above + right)},
                 {lanes_at(p, below + left), lanes_at(p, below + right)}, at.fx, at.fy);
}

// Calls take(channel, value) for each channel, bilinear at these places.
template <class Take>
inline void read_between(const Planes& in, const Places& at, Take&& take) {
  const std::ptrdiff_t plane = static_cast<std::ptrdiff_t>(in.rows) * in.cols;
  if (any_negative(at.x | at.y | (in.cols - 2 - at.x) | (in.rows - 2 - at.y))) {
    for (int channel = 0; channel < in.channels; ++channel) take(channel, read_at_border(in, channel, at));
    return;
  }
  const Whole corner = at.y * in.cols + at.x;
  if (in_a_row(corner)) {
    const float* p = in.first + corner[0];
    for (int channel = 0; channel < in.channels; ++channel)
      take(channel, between_in_a_row(p + channel * plane, in.cols, at.fx, at.fy));
  } else {
    for (int channel = 0; channel < in.channels; ++channel)
      take(channel, between_at(in.first + channel * plane, in.cols, corner, at.fx, at.fy));
  }
}

}  // namespace
}  // namespace hdrcam::HDRCAM_TARGET
