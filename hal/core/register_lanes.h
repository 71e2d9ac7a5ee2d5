// A value as wide as this target's register, for the kernels that are compiled once per instruction set
// (*_kernels.cpp) and fill it: matrix products, and what they are compared with. lanes.h is eight lanes
// everywhere. Internal linkage, as there; a file includes one of the two.
#pragma once

namespace hdrcam::HDRCAM_TARGET {
namespace {

#if defined(__AVX512F__)
constexpr int kLanes = 16;
#elif defined(__AVX__)
constexpr int kLanes = 8;
#else
constexpr int kLanes = 4;
#endif
typedef float Lanes __attribute__((vector_size(kLanes * sizeof(float)), aligned(sizeof(float)), may_alias));

[[maybe_unused]] inline Lanes load(const float* p) { return *reinterpret_cast<const Lanes*>(p); }
[[maybe_unused]] inline void store(float* p, Lanes v) { *reinterpret_cast<Lanes*>(p) = v; }
[[maybe_unused]] inline Lanes splat(float v) { return Lanes{} + v; }
[[maybe_unused]] inline float sum(Lanes v) {
  float total = 0;
  for (int k = 0; k < kLanes; ++k) total += v[k];
  return total;
}

// The two features of an entry of a hash grid, read together.
typedef float Pair __attribute__((vector_size(8), aligned(4), may_alias));
[[maybe_unused]] inline Pair load_pair(const float* p) { return *reinterpret_cast<const Pair*>(p); }

}  // namespace
}  // namespace hdrcam::HDRCAM_TARGET
