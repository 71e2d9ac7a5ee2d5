// Draws the rays of a step: a share of them from the newest frame, the others from any frame of the window;
// within a frame as its picker says, more where rays fitted badly before. A drawn ray carries what its pixel
// measured and what the priors say of it. Reentrant.
#pragma once

#include "online/scene/hash_grid/fit/step_setting.h"

namespace hdrcam {

struct RayDrawing {
  float newest_share;  // of the rays, 0..1: from the newest frame
  bool has_dynamic;    // rays are compared with a neighbour frame, too
};

// Fills rays, a multiple of kRaysPerShard. pickers: by slot of the window's frames, prepared. The window has
// a frame.
void draw_rays(const Window& window, const RayDrawing& how, std::span<const PixelPicker> pickers,
               Pcg32& random, std::span<TrainingRay> rays);

// Tells the pickers how badly each ray was fitted. misfits: photometric, by ray.
void learn_misfits(const Window& window, std::span<const TrainingRay> rays, std::span<const float> misfits,
                   std::span<PixelPicker> pickers);

}  // namespace hdrcam
