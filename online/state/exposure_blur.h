// A forward model of motion blur: an exposed pixel is the mean of the sharp picture over the instants of its
// exposure, each read at its position along the motion. Flow in pixels per frame interval; the exposure is
// centred on the frame's timestamp, as FrameFacts states, and lasts `fraction` of the interval that the flow
// spans. Reentrant.
#pragma once

#include "hal/core/image.h"
#include "hal/core/worker_pool.h"

namespace hdrcam {

// Whether any motion is so long that blur_difference() may be other than zero.
bool exposure_blurs(const Image<float>& flow, float fraction, WorkerPool& pool);

// B(S) - S: the change of the picture S by the exposure's blur. radiance, difference: [rgb or fewer, rows,
// cols]; flow: [dx dy, rows, cols]. Zero where the exposure moves less than .6 pixels: reading between
// pixels would blur more than it.
void blur_difference(const Image<float>& radiance, const Image<float>& flow, float fraction,
                     Image<float>& difference, WorkerPool& pool);

}  // namespace hdrcam
