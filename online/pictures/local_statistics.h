// Small-window statistics of pictures, mirrored at the border. All [n, rows, cols] -> same shape. Reentrant.
#pragma once

#include "hal/core/image.h"
#include "hal/core/worker_pool.h"
#include "online/pictures/picture_kernels.h"

namespace hdrcam {

// Row y of a plane with the rows around it, for picture_kernels().window; variance: null for the mean alone
WindowRow window_at(const float* plane, int rows, int cols, int y, int radius, float* mean, float* variance);

// mean over (2 radius + 1)^2 pixels, radius 1 or 2
void box_mean(const Image<float>& in, int radius, Image<float>& out, WorkerPool& pool);

// mean and variance over 3x3 pixels: the local contrast
void local_contrast(const Image<float>& in, Image<float>& mean, Image<float>& variance, WorkerPool& pool);

}  // namespace hdrcam
