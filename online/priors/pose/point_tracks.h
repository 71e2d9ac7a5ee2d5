// Tracks points of the scene along the optical flow, one per cell of a jittered grid. A point that the flow
// loses for a moment (clipped, occluded) coasts: its depth and the pose predict its position until it is seen
// again or dropped. Deterministic: the jitter is a hash of cell and frame. Thread-bound, owned by the
// tracker.
#pragma once

#include <vector>

#include "online/pictures/flow_field.h"
#include "online/priors/pose/pose_fit.h"

namespace hdrcam {

struct TrackOptions {
  int points = 500;               // grid cells = the most points that are tracked
  float least_confidence = 0.9f;  // of the flow at a point, 0..1
  // Largest difference of the flow within a pixel's neighbours: an edge of motion.
  float flow_disagreement_px = 0.5f;
  int longest_coast = 4;     // frames a point may go unseen
  int longest_track = 60;    // frames: after that the chained flow has drifted too far
  int outlier_patience = 3;  // frames in a row that a point may contradict the pose
  double sigma_px = 0.25;    // start value for one flow vector; then it is measured..
  // ..within these: what moves by itself is no noise, and a wide kernel would let it pull the pose along
  double least_sigma_px = 0.03, most_sigma_px = 0.1;
  double sigma_growth = 0.1;  // of the chain: variance = sigma^2 (1 + growth * age)
  double pull = 0.2;  // share of a point's residual corrected per frame, because the chained flow drifts
  double prior_spread = 1;   // relative standard deviation of the inverse depth of a new point..
  double vague_spread = 10;  // ..and while no depth is known
};

// A picture, and the camera that took it.
struct CameraView {
  int rows, cols;
  const Intrinsics& lens;
  const RigidTransform& T_camera_world;
};

// Whether the depth of any point is known.
enum class Depths { Unknown, Known };

class PointTracks {
 public:
  explicit PointTracks(const TrackOptions& options) : options_(options), noise_px_(options.sigma_px) {}

  // Moves all points along the flow previous -> frame; lost points become unseen.
  void follow(const FlowField& from_previous);
  // Share of the seen points that the last follow() moved by less than this, 0..1.
  double static_share(double px) const;

  // For a static camera: pulls each point towards its predicted position, so that noise cannot add up, and
  // does not age them: what they know of depth must outlast any time that the camera stands still.
  void settle(const Intrinsics& lens, const RigidTransform& T_camera_world);
  // Takes the fitted inverse depths [points] of the points that agree with the pose; drops the others.
  void learn(std::span<const double> inverse_depths, const Intrinsics& lens,
             const RigidTransform& T_camera_world);
  // Updates the flow's noise to `scale` times the assumed one, at the rate 0..1.
  void learn_noise(double scale, double rate);
  double noise_px() const { return noise_px_; }
  // How far the seen points are from where they were first seen, in the median. `ways` is scratch memory.
  double way_px(std::vector<double>& ways) const;
  // Predicts the unseen points' positions; drops points outside the frame, too old or too long unseen.
  void coast(const CameraView& view);
  // Marks all points of this frame as unreliable.
  void mark_all_unseen();
  // While no depth is known all points must have been first seen from one place; if too few are left, all are
  // restarted.
  void restart_when_thin();
  // Fills the empty cells. confidence: [1, rows, cols] of this frame's flow, or empty: everywhere.
  void seed(const Image<float>& confidence, const CameraView& view, Depths depths);

  std::span<const ScenePoint> points() const { return points_; }
  void inverse_depths(std::vector<double>& depths) const;
  int seen() const;

 private:
  struct History {
    double seed_information = 1;  // of the prior it started with
    double moved_px = 0;          // by the last follow()
    int age = 0, unseen = 0, outlier = 0;
    Eigen::Vector2d first_px = Eigen::Vector2d::Zero();  // where it was first seen
  };

  void remove(std::size_t i);
  double sigma_of(const History& history) const;
  double expected_inverse_depth(const Eigen::Vector2d& px, double reach_px,
                                const RigidTransform& T_camera_world) const;

  TrackOptions options_;
  std::vector<ScenePoint> points_;
  std::vector<History> histories_;  // of points_[i]
  std::vector<char> occupied_;      // [cells]
  double noise_px_;
  unsigned frame_ = 0;
};

}  // namespace hdrcam
