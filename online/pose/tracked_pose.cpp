#include "online/pose/tracked_pose.h"

#include <algorithm>
#include <cmath>

#include "online/pose/heading_search.h"

namespace hdrcam {
namespace {

constexpr int kTurnSteps = 6, kMoveSteps = 8, kFirstMoveSteps = 10;  // Gauss-Newton
constexpr int kHeadingsTried = 4;
constexpr double kNoiseLearning = 0.2;  // of the measured noise, per frame

}  // namespace

TrackedPose::TrackedPose(std::optional<Intrinsics> intrinsics, const TrackerOptions& options)
    : options_(options), intrinsics_(intrinsics), tracks_(options.tracks) {}

const CameraPose& TrackedPose::next(const FrameFacts&, const FlowField& to_previous, const FlowField& from_previous) {
  if (from_previous.empty()) return pose_;
  const int rows = from_previous.vectors.rows(), cols = from_previous.vectors.cols();
  if (!started_) start(from_previous);
  track(from_previous);
  tracks_.depth_samples(T_camera_world_, pose_.depth_samples);
  tracks_.coast(lens_, T_camera_world_, rows, cols);
  if (!depth_known_) tracks_.restart_when_thin();
  tracks_.seed(to_previous.confidence, rows, cols, lens_, T_camera_world_, depth_known_);
  pose_.T_world_camera = to_matrix(T_camera_world_.inverse());
  return pose_;
}

// The first flow says how large the frames are; the first frame's points sit where it can follow them.
void TrackedPose::start(const FlowField& from_previous) {
  const int rows = from_previous.vectors.rows(), cols = from_previous.vectors.cols();
  lens_ = intrinsics_.value_or(assumed_intrinsics(rows, cols));
  tracks_.seed(from_previous.confidence, rows, cols, lens_, T_camera_world_, depth_known_);
  started_ = true;
}

void TrackedPose::track(const FlowField& from_previous) {
  tracks_.follow(from_previous);
  if (tracks_.seen() < options_.fewest_points) return lose();

  depths_ = tracks_.inverse_depths();
  trial_depths_ = depths_;
  const PoseFit turned =
      fit_pose(tracks_.points(), lens_, T_camera_world_, {.freedom = Freedom::Rotation, .steps = kTurnSteps}, trial_depths_);
  if (stands_still(turned)) {
    tracks_.settle(lens_, T_camera_world_);
    return accept(T_camera_world_, CameraMotion::Still, tracks_.still_share(options_.still_px));
  }
  if (depth_known_)
    follow_translation(turned);
  else
    find_translation(turned);
}

// The depths hold the scale: the translation is the one that they see.
void TrackedPose::follow_translation(const PoseFit& turned) {
  const PoseFit moved = fit_pose(tracks_.points(), lens_, turned.T_camera_world, {.steps = kMoveSteps}, depths_);
  if (std::max(turned.inlier_share, moved.inlier_share) < options_.fewest_inliers) return lose();
  const bool was_moving = pose_.motion == CameraMotion::General;
  if (turned.cost - moved.cost < (was_moving ? options_.translation_gain_on : options_.translation_gain))
    return accept(turned.T_camera_world, CameraMotion::Rotation, turned.inlier_share);
  tracks_.learn_noise(noise_across(tracks_.points(), depths_, lens_, moved.T_camera_world), kNoiseLearning);
  tracks_.learn(depths_, lens_, moved.T_camera_world);
  accept(moved.T_camera_world, CameraMotion::General, moved.inlier_share);
}

// No depth is known yet, all points were first seen from the world's origin. A translation is believed once it explains
// much more than free depths explain of mere noise.
void TrackedPose::find_translation(const PoseFit& turned) {
  const auto points = tracks_.points();
  auto logc=[&](const RigidTransform&T,const std::vector<double>&d,double s0){double c=0;int n=0;for(size_t i=0;i<points.size();++i)if(points[i].seen){PointResidual r;double e=point_residual(points[i],d[i],lens_,T,r)?r.px.squaredNorm():1e4;c+=std::log1p(e/(s0*s0));++n;}return c/n;};
  static int ff; ++ff;
  struct C{RigidTransform T;std::vector<double> d;double c,s;}; std::vector<C> cs;
  for (Heading& heading : search_headings(points, lens_, turned.T_camera_world, kHeadingsTried)) {
    PoseFit fit; fit.T_camera_world = heading.T_camera_world;
    double scale = 1;
    for (int round = 0; round < 3; ++round) {
      fit = fit_pose(points, lens_, fit.T_camera_world, {.steps = 6, .noise_scale = scale, .widest_sigmas = 6}, heading.inverse_depths);
      scale = std::clamp(noise_across(points, heading.inverse_depths, lens_, fit.T_camera_world), 0.03/.25, 0.6/.25);
    }
    cs.push_back({fit.T_camera_world, heading.inverse_depths, logc(fit.T_camera_world, heading.inverse_depths, .1), scale});
  }
  std::sort(cs.begin(), cs.end(), [](auto&a, auto&b){return a.c<b.c;});
  if (getenv("PDBG")) { fprintf(stderr, "find: turned %.3f\n", logc(turned.T_camera_world, trial_depths_, .1));
    for (auto&c:cs){auto b=c.T.t.normalized();std::vector<double> par;double big=0;for(size_t i=0;i<points.size();++i)if(points[i].seen){PointResidual r;if(point_residual(points[i],c.d[i],lens_,c.T,r))par.push_back(r.per_inverse_depth.norm()*c.d[i]);}for(double p:par)big+=p>5*c.s*.25;std::nth_element(par.begin(),par.begin()+par.size()/2,par.end());
     Eigen::Vector3d C=-(c.T.R.transpose()*c.T.t).normalized();fprintf(stderr,"   C %.2f %.2f %.2f rotvs %.3fdeg logc %.3f sigma %.3f medpar %.2f big %.2f\n",C.x(),C.y(),C.z(),Eigen::AngleAxisd(c.T.R*turned.T_camera_world.R.transpose()).angle()*57.3,c.c,c.s*.25,par[par.size()/2],big/par.size());} }
  return accept(turned.T_camera_world, CameraMotion::Rotation, turned.inlier_share);
  PoseFit moved;
  RigidTransform T_camera_world = moved.T_camera_world;
  choose_unit(T_camera_world);
  tracks_.learn(depths_, lens_, T_camera_world);
  accept(T_camera_world, CameraMotion::General, moved.inlier_share);
}

// The median depth becomes the unit of length.
void TrackedPose::choose_unit(RigidTransform& T_camera_world) {
  trial_depths_ = depths_;
  const auto middle = trial_depths_.begin() + static_cast<std::ptrdiff_t>(trial_depths_.size() / 2);
  std::nth_element(trial_depths_.begin(), middle, trial_depths_.end());
  const double median = std::max(*middle, 1e-6);
  T_camera_world.t *= median;
  for (double& depth : depths_) depth /= median;
  depth_known_ = true;
}

bool TrackedPose::stands_still(const PoseFit& turned) const {
  if (tracks_.still_share(options_.still_px) < options_.still_share) return false;
  const Eigen::AngleAxisd turn(turned.T_camera_world.R * T_camera_world_.R.transpose());
  const Eigen::Vector3d angle = turn.angle() * turn.axis();
  const double drift_px = std::max(lens_.fx_px * std::hypot(angle.x(), angle.y()), 0.5 * lens_.cx_px * std::abs(angle.z()));
  return drift_px < options_.still_drift_px;
}

void TrackedPose::accept(const RigidTransform& T_camera_world, CameraMotion motion, double inlier_share) {
  T_camera_previous_ = T_camera_world * T_camera_world_.inverse();
  T_camera_world_ = T_camera_world;
  pose_.motion = motion;
  pose_.inlier_share = static_cast<float>(inlier_share);
  pose_.lost = false;
}

void TrackedPose::lose() {
  const Eigen::AngleAxisd turn(T_camera_previous_.R);
  T_camera_previous_.R = rotation(options_.velocity_decay * turn.angle() * turn.axis());
  T_camera_previous_.t *= options_.velocity_decay;
  T_camera_world_ = T_camera_previous_ * T_camera_world_;
  T_camera_world_.R = orthonormal(T_camera_world_.R);
  tracks_.mark_all_unseen();
  pose_.inlier_share = 0;
  pose_.lost = true;
}

}  // namespace hdrcam
