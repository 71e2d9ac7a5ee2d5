// The white balance of what leaves: radiance is fitted in the camera's own colours, and only the emitted
// frame is multiplied with the gains that the camera states for the light of the scene. Reentrant.
#pragma once

#include <optional>

#include "hal/core/result.h"
#include "render/hdr_frame.h"

namespace hdrcam {

enum class WhiteBalance {
  None,    // the camera's own colours
  Camera,  // as the camera states it
};

// The gains to apply, none for None. Errors: Unsupported where they are wanted and the camera states none.
Result<std::optional<ChannelGains>> white_balance_gains(WhiteBalance wanted, const CameraFacts& camera);

// Multiplies radiance and points, and notes the gains in the frame. A channel that is clipped in all
// exposures is a lower bound, so it is raised to the largest channel of its pixel: what is too bright for the
// sensor stays white, where the gains alone would make it magenta. `white` becomes that of the largest
// channel.
void apply_white_balance(const ChannelGains& gains, HdrFrame& frame);

}  // namespace hdrcam
