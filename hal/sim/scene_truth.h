// What is known of a frame besides its pixels, as an ideal sensor would see it: global shutter, sharp, no
// noise; the lens's distortion is kept, so that it lies pixel on pixel over the frames.
#pragma once

#include <cstdint>

#include "hal/sim/renderer.h"

namespace hdrcam {

struct SceneTruth {
  Image<float> radiance;  // [rgb, rows, cols]
  Image<float> depth;     // [1, rows, cols] camera z, metres
  Image<float>
      flow;  // [dx dy occluded, rows, cols] pixels to the next instant; occluded: 1 where hidden there
  Image<std::uint8_t> ids;  // [1, rows, cols] index into Scene::objects
  Pose T_world_camera;
};

// Thread-bound; owns its buffers.
class TruthRenderer {
 public:
  // The scene and the pool outlive it.
  TruthRenderer(const Scene& scene, Lens lens, int rows, int cols, WorkerPool& pool);

  // At the instant now_s of the scene; the flow leads to next_s.
  void render(double now_s, double next_s, SceneTruth& truth);

 private:
  void trace_row(int y, SceneTruth& truth) const;

  const Scene& scene_;
  Lens lens_;
  int rows_, cols_;
  WorkerPool& pool_;
  Renderer sharp_;
  View now_, next_;
};

}  // namespace hdrcam
