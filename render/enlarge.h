// A picture of every `step`-th pixel of a view, at the view's full size: bilinear. Reentrant.
#pragma once

#include "hal/core/worker_pool.h"
#include "online/pictures/between_pixels.h"

namespace hdrcam {

// Where a full-size pixel reads such a picture, of `size` pixels along one axis.
AxisTap reduced_tap(int at, int step, int size);

// out: becomes [channels of `in`, rows, cols].
void enlarge(const Image<float>& in, int step, int rows, int cols, Image<float>& out, WorkerPool& pool);

}  // namespace hdrcam
