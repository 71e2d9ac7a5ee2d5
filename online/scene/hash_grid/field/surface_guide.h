// How deep the surfaces of a new frame of the window are taken to be: the depth prior where it is known, else
// the frame's guide, one value for each tile of pixels, which goes on from frame to frame. Reentrant.
#pragma once

#include "hal/core/worker_pool.h"
#include "online/pictures/flow_field.h"
#include "online/scene/hash_grid/field/view_geometry.h"
#include "online/scene/hash_grid/field/window.h"

namespace hdrcam {

constexpr float kMaxFlow_px = 512;  // of the stream; what is longer counts as this long

// The guide of a new frame: the previous one's, warped along the flow.
void carry_guide(const WindowFrustum& frustum, const WindowFrame& from, const FlowField& to_previous,
                 WindowFrame& to);
// Where a prior covers enough of a tile, its mean is the guide.
void guide_by_prior(const WindowFrustum& frustum, WindowFrame& frame);
// Writes the base's surface: the prior where it is known, the guide elsewhere.
void take_surface(const WindowFrustum& frustum, WindowFrame& frame, WorkerPool& pool);

}  // namespace hdrcam
