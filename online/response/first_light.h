// Whether the light changes from one of the first frames to the next, as that of lamps on the mains does,
// which a short exposure sees a moment of. Histograms of two exposures then do not tell their ratio: a
// frame's own light counts as exposure. Frames of one exposure tell it, cell by cell. Reentrant.
#pragma once

#include <span>
#include <vector>

#include "capture/compact_frame.h"
#include "online/response/response.h"

namespace hdrcam {

// For each frame, ln of its light over the mean of the frames of its exposure; empty where light is steady,
// or changes one way only, as a picture does that is panned over. assumed: the response as far as it is
// known.
std::vector<float> unsteady_light(std::span<const CompactFrame> frames, const Response& assumed);

}  // namespace hdrcam
