// Loops over the samples of whole pictures on all threads of a pool, each with the rows that it has in other
// loops: what is done to a sample depends on samples of the same index only. Thread-bound, as the pool.
#pragma once

#include <cstddef>

#include "hal/core/image.h"
#include "hal/core/worker_pool.h"

namespace hdrcam {

// Calls body(i0, i1) for bands of rows of each channel; i: index of a sample in pictures of this shape.
template <class Body>
void for_samples(const Image<float>& shape, WorkerPool& pool, Body&& body) {
  pool.for_rows(shape.rows(), [&](int y0, int y1) {
    for (int c = 0; c < shape.channels(); ++c) {
      const float* first = shape.plane(0);
      body(static_cast<std::size_t>(shape.row(c, y0) - first),
           static_cast<std::size_t>(shape.row(c, y1) - first));
    }
  });
}

}  // namespace hdrcam
