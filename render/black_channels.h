// Light of channels that even the longest exposure shows black: all that is known of it is that it is less
// than a dark code means, which may be much where the camera's curve has a toe, and differs by channel. There
// the other channels tell more: the channel gets the picture's usual colour at their level, if that is
// darker. For the output only. Reentrant.
#pragma once

#include <array>

#include "hal/core/image.h"
#include "hal/core/worker_pool.h"
#include "online/state/radiance_state.h"

namespace hdrcam {

struct BlackChannels {
  std::array<float, 3> darkest;  // radiance up to which even the longest exposure is black
  float unseen_from;             // variance from which on a pixel counts as unseen
  float offset;                  // radiance below which a difference does not matter
};

// coloured: becomes the radiance with these channels coloured; another picture than that of `seen`.
void colour_black_channels(const BlackChannels& black, const RadianceEstimate& seen, Image<float>& coloured,
                           WorkerPool& pool);

}  // namespace hdrcam
