// Inverse depth per pixel from the motion of the last frames: each pixel remembers where it was in two
// earlier frames, the keyframes, carried along the flow from frame to frame; the poses turn that long
// displacement into a depth. The estimate from a keyframe is kept when it is replaced (a Gaussian filter of
// inverse depth, carried along the motion), so that the baselines of the whole window add up, while the error
// of a single flow does not. Pixels whose displacement is not along their epipolar line are dynamic or wrong:
// their weight is 0. Needs a moving camera: a static or rotating one adds no information, and the known depth
// is kept. Thread-bound; the result does not depend on the number of threads.
#pragma once

#include <array>
#include <vector>

#include "hal/core/geometry.h"
#include "hal/core/worker_pool.h"
#include "online/pictures/flow_field.h"
#include "online/priors/depth/depth_prior.h"

namespace hdrcam {

struct GridPlace;

struct DepthOptions {
  int step_px = 2;                 // of the grid that is filtered: 2 is as accurate at a quarter of the cost
  float least_confidence = 0.7f;   // of the flow, 0..1
  float noise_px = 0.2f;           // of one flow vector, standard deviation..
  float noise_growth_px = 0.1f;    // ..and of each further one in the chain
  float epipolar_sigmas = 2.5f;    // a pixel farther from its epipolar line is not static
  float keyframe_parallax_px = 8;  // median, after which the next keyframe is taken
  int keyframe_frames = 12;        // at the latest
  float forget = 0.02f;            // relative growth of the standard deviation per frame
  float best_relative = 0.03f;     // lower limit of an inverse depth's relative uncertainty
};

class MultiViewDepth final : public DepthPrior {
 public:
  MultiViewDepth(const DepthOptions& options, const Intrinsics& lens, int rows, int cols, WorkerPool& pool);

  // to_previous: this frame -> the previous one, [dx dy, rows, cols] px; empty for the first. The prior is of
  // this frame, [1, rows / step_px, cols / step_px], but at least two points along either side. It belongs to
  // this object until the next call.
  const DepthMap& next(const CameraPose& pose, const FlowField& to_previous);

  // Of the same frame and grid, [1, rows, cols]: 1 where a point is known to have moved against the static
  // scene, 0 where it is static or nothing is known.
  const Image<float>& dynamic() const { return dynamic_; }

  const DepthMap& estimate(const SeenFrame& seen, const CameraPose& pose) override {
    return next(pose, seen.motion.to_previous);
  }

 private:
  struct Keyframe {
    RigidTransform T_world_camera;
    Image<float> seen;     // [x y known, rows, cols]: where this grid point was in the keyframe, grid steps
    Image<float> carried;  // the same of the next frame, borrowed meanwhile
    int age = 0;           // frames
  };
  enum class Seen { Nothing, Static, Dynamic };
  struct Measured {
    Seen point = Seen::Nothing;
    float inverse_depth = 0, information = 0;  // of a static one; information: 1 / variance
  };
  struct Relative;  // the pose between two views, prepared for a pixel loop

  void restart(const RigidTransform& T_world_camera);
  void begin(Keyframe& keyframe, const RigidTransform& T_world_camera);
  void carry(const FlowField& to_previous, const Relative& previous);
  void carry_position(Keyframe& keyframe, const GridPlace& from, int y, int x);
  void carry_depth(const Relative& previous, const GridPlace& from, int y, int x);
  float sigma_px(const Keyframe& keyframe) const;
  Measured measure(const Keyframe& keyframe, const Relative& relative, int y, int x) const;
  void fuse();
  void retire(const Keyframe& keyframe);
  float median_parallax(const Keyframe& keyframe);

  DepthOptions options_;
  Intrinsics lens_;
  int rows_, cols_;  // of the grid
  WorkerPool& pool_;
  RigidTransform T_world_camera_;
  std::array<Keyframe, 2> keyframes_;  // old, young
  Image<float> learnt_;                // [inverse depth, information, rows, cols] from earlier keyframes
  Image<float> carried_learnt_;        // the same of the next frame, borrowed meanwhile
  std::vector<float> parallaxes_;
  bool started_ = false;
  DepthMap prior_;
  Image<float> dynamic_;
};

}  // namespace hdrcam
