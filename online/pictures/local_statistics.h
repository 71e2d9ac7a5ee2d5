// Small-window statistics of pictures, mirrored at the border. All [n, rows, cols] -> same shape. Reentrant.
#pragma once

#include "hal/core/image.h"
#include "hal/core/worker_pool.h"

namespace hdrcam {

// mean over (2 radius + 1)^2 pixels, radius 1 or 2
void box_mean(const Image<float>& in, int radius, Image<float>& out, WorkerPool& pool);

// mean and variance over 3x3 pixels: the local contrast
void local_contrast(const Image<float>& in, Image<float>& mean, Image<float>& variance, WorkerPool& pool);

// What motion blur adds to a sample, to second order: second difference of the radiance along the motion
// times (blur length)^2 / 24, with blur length = |flow| * fraction (fraction: exposure time over frame
// interval).
void blur_bias(const Image<float>& radiance, const Image<float>& flow, float fraction, Image<float>& bias,
               WorkerPool& pool);

}  // namespace hdrcam
