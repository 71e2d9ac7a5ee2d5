// Eight floats as one value, for the kernels that are compiled once per instruction set (*_kernels.cpp, see
// hdrcam_kernels() in CMakeLists.txt): a register of AVX2, half one of AVX-512, two of SSE or NEON.
// Everything here has internal linkage, so that no instruction of one object can leak into another.
#pragma once

namespace hdrcam::HDRCAM_TARGET {
namespace {

constexpr int kLanes = 8;
typedef float Lanes __attribute__((vector_size(kLanes * sizeof(float)), aligned(sizeof(float)), may_alias));

[[maybe_unused]] inline Lanes load(const float* p) { return *reinterpret_cast<const Lanes*>(p); }
[[maybe_unused]] inline void store(float* p, Lanes v) { *reinterpret_cast<Lanes*>(p) = v; }

// For loops that are written once for vectors and for what is over at a row's end: V is Lanes or float.
template <class V>
inline V get(const float* p) {
  if constexpr (sizeof(V) == sizeof(Lanes))
    return load(p);
  else
    return *p;
}
template <class V>
inline void put(float* p, V value) {
  if constexpr (sizeof(V) == sizeof(Lanes))
    store(p, value);
  else
    *p = value;
}
// V{} + value in every lane.
template <class V>
inline V all(float value) {
  return V{} + value;
}

// Calls body(x, V{}) for all n pixels of a row, some at a time.
template <class Body>
inline void across(int n, Body&& body) {
  int x = 0;
  for (; x + kLanes <= n; x += kLanes) body(x, Lanes{});
  for (; x < n; ++x) body(x, 0.f);
}

// Lane by lane; also of single numbers. Where one of them is not a number: b, and `low` of a clamped one.
template <class V>
inline V least(V a, V b) {
  return a < b ? a : b;
}
template <class V>
inline V most(V a, V b) {
  return a > b ? a : b;
}
template <class V>
inline V clamped(V v, float low, float high) {
  return least(most(v, all<V>(low)), all<V>(high));
}
// 0 up to `begin`, 1 from `end` on, a smooth cubic between.
template <class V>
inline V smooth_step(float begin, float end, V x) {
  const V t = clamped((x - begin) * (1 / (end - begin)), 0, 1);
  return t * t * (3 - 2 * t);
}

}  // namespace
}  // namespace hdrcam::HDRCAM_TARGET
