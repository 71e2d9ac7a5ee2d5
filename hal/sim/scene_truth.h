// The ground truth of a frame, as an ideal sensor behind the same lens would see it: sharp, all rows at one
// instant, without flare, flicker, leaks or noise. Constant properties of the lens, distortion and
// vignetting, are kept, so that the truth matches the frames pixel by pixel and stop by stop.
#pragma once

#include <cstdint>

#include "hal/sim/effects/vignetting.h"
#include "hal/sim/renderer.h"

namespace hdrcam {

struct SceneTruth {
  double time_s = 0;      // the instant, in the time of the scene
  Image<float> radiance;  // [rgb, rows, cols]
  Image<float> depth;     // [1, rows, cols] camera z, metres
  // [dx dy occluded, rows, cols] pixels to the next instant; occluded: 1 where hidden there.
  Image<float> flow;
  Image<std::uint8_t> ids;  // [1, rows, cols] index into Scene::objects
  Pose T_world_camera;
};

// Thread-bound; owns its buffers.
class TruthRenderer {
 public:
  // The scene, the pool and the vignetting, which may be null, outlive it.
  TruthRenderer(const Scene& scene, Lens lens, int rows, int cols, WorkerPool& pool,
                const Vignetting* vignetting = nullptr);

  // Computes the truth at the instant now_s of the scene; the flow leads to next_s.
  void render(double now_s, double next_s, SceneTruth& truth);

 private:
  void trace_row(int y, SceneTruth& truth) const;

  const Scene& scene_;
  Lens lens_;
  int rows_, cols_;
  WorkerPool& pool_;
  const Vignetting* vignetting_;
  Renderer sharp_;
  View now_, next_;
};

}  // namespace hdrcam
