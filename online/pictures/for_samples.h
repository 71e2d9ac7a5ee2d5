// Loops over the samples of whole pictures on all threads of a pool: what is done to a sample depends on
// samples of the same index only. Thread-bound, as the pool.
#pragma once

#include <algorithm>
#include <cstddef>

#include "hal/core/image.h"
#include "hal/core/worker_pool.h"

namespace hdrcam {

// Calls body(i0, i1) for consecutive parts of [0, size).
template <class Body>
void for_samples(std::size_t size, WorkerPool& pool, Body&& body) {
  constexpr std::size_t kPart = 1 << 15;
  pool.for_each(static_cast<int>((size + kPart - 1) / kPart), [&](int i) {
    const std::size_t i0 = static_cast<std::size_t>(i) * kPart;
    body(i0, std::min(size, i0 + kPart));
  });
}

inline void copy(const Image<float>& from, Image<float>& to, WorkerPool& pool) {
  to.reshape_like(from);
  const float* in = from.plane(0);
  float* out = to.plane(0);
  for_samples(from.size(), pool,
              [=](std::size_t i0, std::size_t i1) { std::copy(in + i0, in + i1, out + i0); });
}

}  // namespace hdrcam
