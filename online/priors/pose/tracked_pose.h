// The camera's pose from the optical flow alone. Per frame it carries the points of the scene along the flow
// and fits a rotation about the camera's centre, then a rotation with a translation. It accepts the
// translation only where it explains clearly more (a static or rotating camera is the normal case, and its
// position is then kept exactly). The depths learnt from earlier frames fix the scale. Thread-bound.
#pragma once

#include <optional>

#include "online/priors/pose/heading_search.h"
#include "online/priors/pose/point_tracks.h"
#include "online/priors/pose/pose_prior.h"

namespace hdrcam {

struct TrackerOptions {
  TrackOptions tracks;
  double static_px = 0.15;          // flow below this is no motion
  double static_share = 0.5;        // of the points, for a static camera
  double static_drift_px = 0.3;     // accumulated small motion that counts as real motion
  double translation_gain = 60;     // squared sigmas that a translation must explain to be accepted..
  double translation_gain_on = 15;  // ..and while the camera is moving already
  // The first translation is accepted where this share of the points shows clear parallax..
  double parallax_share = 0.3;
  double heading_noise_ratio = 0.8;  // ..and the best heading's noise is below this share of any other's
  int fewest_points = 30;            // below this the pose is lost
  double fewest_inliers = 0.3;       // share
  double velocity_decay = 0.9;       // per frame, while lost
  // Frames in a row that are clipped, dark or bright, but for so small a share: so many have the motion of
  // those around them, as in a cycle with black frames; after them it is only continued, and the pose is
  // lost.
  int longest_blind = 4;
  double least_shown = 0.02;
};

class TrackedPose final : public PosePrior {
 public:
  TrackedPose(std::optional<Intrinsics> intrinsics, WorkerPool& pool);

  // to_previous: this frame -> the previous one; from_previous: the reverse; empty for the first frame.
  const CameraPose& next(const FlowField& to_previous, const FlowField& from_previous);
  const CameraPose& estimate(const SeenFrame& seen) override;
  PoseSource source() const override { return PoseSource::Tracked; }

 private:
  enum class Centre { Kept, Moved };  // of the camera

  void start(const FlowField& from_previous);
  void track(const FlowField& from_previous);
  void find_translation(const PoseFit& turned);
  void follow_translation(const PoseFit& turned);
  void choose_unit(Heading& first);
  bool is_static(const PoseFit& turned) const;
  void note_velocity(const RigidTransform& T_camera_world);
  void accept(const RigidTransform& T_camera_world, Centre centre);
  void lose();

  const TrackerOptions options_;
  std::optional<Intrinsics> intrinsics_;
  Intrinsics lens_;
  PointTracks tracks_;
  RigidTransform T_camera_world_;
  RigidTransform T_camera_previous_;                    // the velocity: the motion of the last frame
  std::vector<double> depths_, trial_depths_, errors_;  // [points] of one frame
  PoseFitter fitter_;
  bool started_ = false;
  Depths depths_known_ = Depths::Unknown;
  Centre centre_ = Centre::Kept;  // by the accepted motion
  int blind_ = 0;                 // frames in a row
  CameraPose pose_;
};

}  // namespace hdrcam
