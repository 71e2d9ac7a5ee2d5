// Warps pictures along a flow: out(p) = in(p + flow(p)). Positions are rounded to 1/32 pixel, so that a
// static pixel is copied, not interpolated, despite the flow's noise; outside the picture the border pixel is
// repeated. Reentrant.
#pragma once

#include "hal/core/image.h"
#include "hal/core/worker_pool.h"

namespace hdrcam {

// Cubic convolution (a = -0.5, Catmull-Rom), every channel. in, out: [n, rows, cols]; flow: [dx dy, rows,
// cols] pixels.
void warp_cubic(const Image<float>& in, const Image<float>& flow, Image<float>& out, WorkerPool& pool);
// The same of radiance, in its logarithm, in which an edge to bright light weighs no more than what is beside
// it; radiance + kDarkRadiance (picture_kernels.h) is within a factor of e^kMostRinging of its bilinear
// value, so that no ringing builds up in a recursion. in: nothing below 0; borrows a picture from the pool.
inline constexpr float kMostRinging = 0.5f;
void warp_radiance(const Image<float>& in, const Image<float>& flow, Image<float>& out, WorkerPool& pool);
// warp_cubic; largest: becomes the largest of the four pixels around each place.
void warp_cubic_and_largest(const Image<float>& in, const Image<float>& flow, Image<float>& out,
                            Image<float>& largest, WorkerPool& pool);

void warp_linear(const Image<float>& in, const Image<float>& flow, Image<float>& out, WorkerPool& pool);

}  // namespace hdrcam
