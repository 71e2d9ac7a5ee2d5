// The depth that the fit has learned, as the guide of rays: samples are placed around it. Reentrant for
// distinct windows and probes.
#pragma once

#include "online/scene/hash_grid/field/field_probe.h"

namespace hdrcam {

// The depth that the networks have learned for the newest frame, where no prior knows it, becomes the guide
// (inverse depth, 0.01..0.95) of its rays and, carried along the flow by Window::advance(), of the next
// frame's. Half of the tiles, in turn, a frame. field: of this window. Does nothing without a frame or
// parallax.
void refresh_guide(Window& window, const RadianceField& field, FieldProbe& probe);

}  // namespace hdrcam
