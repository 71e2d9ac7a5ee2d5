// Warps pictures along a flow: out(p) = in(p + flow(p)). Positions are rounded to 1/32 pixel, so that a
// static pixel is copied, not interpolated, despite the flow's noise; outside the picture the border pixel is
// repeated. Reentrant.
#pragma once

#include "hal/core/image.h"
#include "hal/core/worker_pool.h"

namespace hdrcam {

// Cubic convolution (a = -0.5, Catmull-Rom), every channel; with `limit` > 0 the result stays within 1 -+
// limit of the bilinear value, so that no ringing builds up in a recursion. in, out: [n, rows, cols]; flow:
// [dx dy, rows, cols] pixels.
void warp_cubic(const Image<float>& in, const Image<float>& flow, float limit, Image<float>& out,
                WorkerPool& pool);
// The same without a limit; largest: becomes the largest of the four pixels around each place.
void warp_cubic_and_largest(const Image<float>& in, const Image<float>& flow, Image<float>& out,
                            Image<float>& largest, WorkerPool& pool);

void warp_linear(const Image<float>& in, const Image<float>& flow, Image<float>& out, WorkerPool& pool);

}  // namespace hdrcam
