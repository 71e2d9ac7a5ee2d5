// Points on the scene's static surfaces, from the depth that was measured at a frame (not the field's, which
// answers everywhere): every 8th pixel along both axes, where the relative uncertainty of the depth is at
// most a tenth. Moving things have no such depth and give no points. Reentrant.
#pragma once

#include <vector>

#include "online/frame_estimate.h"
#include "render/hdr_frame.h"

namespace hdrcam {

inline constexpr int kSurfacePointStep_px = 8;

// radiance: [rgb, rows, cols] of the emitted frame. Replaces what `points` holds; none without a pose, and
// none where the pose is lost.
void find_surface_points(const FrameEstimate& estimate, const Image<float>& radiance,
                         std::vector<SurfacePoint>& points);

}  // namespace hdrcam
