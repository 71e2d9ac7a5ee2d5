// What motion during an exposure does to a sharp picture, as a forward model: an exposed pixel is the mean of
// the picture over the instants of its exposure, each read where the motion has it then. Flow in pixels per
// frame interval; the exposure is centred on the frame's timestamp, as FrameFacts promise, and lasts
// `fraction` of the interval that the flow spans. Reentrant.
#pragma once

#include "hal/core/image.h"
#include "hal/core/worker_pool.h"

namespace hdrcam {

// B(S) - S: what the exposure adds to the picture S. radiance, difference: [n, rows, cols]; flow: [dx dy,
// rows, cols]. Zero where the motion stays below a third of a pixel.
void blur_difference(const Image<float>& radiance, const Image<float>& flow, float fraction,
                     Image<float>& difference, WorkerPool& pool);

}  // namespace hdrcam
