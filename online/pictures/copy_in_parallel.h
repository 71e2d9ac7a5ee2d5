// Copies a picture on all threads of a pool. Thread-bound, as the pool.
#pragma once

#include <algorithm>

#include "hal/core/image.h"
#include "hal/core/worker_pool.h"

namespace hdrcam {

// to: gets the shape of `from`.
inline void copy_in_parallel(const Image<float>& from, Image<float>& to, WorkerPool& pool) {
  to.reshape_like(from);
  pool.for_rows(from.rows(), [&](int y0, int y1) {
    for (int c = 0; c < from.channels(); ++c) std::copy(from.row(c, y0), from.row(c, y1), to.row(c, y0));
  });
}

}  // namespace hdrcam
