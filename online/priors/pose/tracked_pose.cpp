#include "online/priors/pose/tracked_pose.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "capture/clip_policy.h"
#include "capture/clipped_pixel.h"
#include "hal/core/median.h"
#include "online/priors/pose/heading_search.h"

namespace hdrcam {
namespace {

constexpr int kTurnSteps = 6, kMoveSteps = 8;  // of Gauss-Newton
constexpr int kHeadingsTried = 6, kHeadingRounds = 3, kHeadingSteps = 5, kHeadingPoints = 160,
              kDepthSteps = 6;
constexpr double kSameHeading = 0.9;  // cosine
// An error above the flow's usual noise; of a point's way, that above what a chain of flow gathers in a pan
// (2 to 3 percent) and what a lens that bends the picture adds (5).
constexpr double kUnexplained_px = 0.6, kUnexplainedOfWay = 0.07;
constexpr double kClearParallax_sigmas = 5, kClearParallax_px = 1.5;
constexpr double kNoiseLearning = 0.2;  // of the measured noise, per frame

// Share of the seen points that disagree with the pose by more than this.
double unexplained_share(std::span<const ScenePoint> points, const Intrinsics& lens,
                         const RigidTransform& T_camera_world, double px) {
  int seen = 0, off = 0;
  for (const ScenePoint& point : points) {
    if (!point.seen) continue;
    const auto r = point_residual(point, point.inverse_depth, lens, T_camera_world);
    const bool near = r && r->px.norm() < px;
    ++seen, off += !near;
  }
  return seen > 0 ? static_cast<double>(off) / seen : 0;
}

// Share of the seen points that the translation moves by more than this.
double parallax_share(std::span<const ScenePoint> points, const Heading& heading, const Intrinsics& lens,
                      double px) {
  int seen = 0, clear = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].seen) continue;
    const auto r = point_residual(points[i], heading.inverse_depths[i], lens, heading.T_camera_world);
    if (!r) continue;
    ++seen, clear += r->per_inverse_depth.norm() * heading.inverse_depths[i] > px;
  }
  return seen > 0 ? static_cast<double>(clear) / seen : 0;
}

// Every n-th of them, about `count`.
std::vector<ScenePoint> thinned(std::span<const ScenePoint> points, std::size_t count) {
  std::vector<ScenePoint> some;
  for (std::size_t i = 0; i < points.size(); i += 1 + points.size() / (count + 1)) some.push_back(points[i]);
  return some;
}

void refine(std::span<const ScenePoint> points, const Intrinsics& lens, int rounds, PoseFitter& fitter,
            Heading& heading) {
  constexpr double kLeastNoise = 0.1, kMostNoise = 2.5;  // in sigmas of the tracks, which are not learnt yet
  constexpr double kWidest_sigmas = 6;                   // half of the usual: a heading starts near
  std::vector<double> errors;
  for (int round = 0; round < rounds; ++round) {
    const FitOptions options{.steps = kHeadingSteps,
                             .noise_scale = std::clamp(heading.noise, kLeastNoise, kMostNoise),
                             .widest_sigmas = kWidest_sigmas};
    heading.T_camera_world =
        fitter.fit(points, lens, heading.T_camera_world, options, heading.inverse_depths).T_camera_world;
    heading.noise = noise_across(points, heading.inverse_depths, lens, heading.T_camera_world, errors);
  }
}

bool same_heading(const Heading& a, const Heading& b) {
  const Eigen::Vector3d centre_a = a.T_camera_world.inverse().t.normalized();
  return centre_a.dot(b.T_camera_world.inverse().t.normalized()) > kSameHeading;
}

// Share of the pixels that are not clipped, dark or bright, in all channels; of a part of them.
double shown_share(const Image<float>& codes) {
  constexpr int kStride = 4;
  const clip_policy::UsableCodes usable = clip_policy::kMotionRating;
  int shown = 0, all = 0;
  for (int y = 0; y < codes.rows(); y += kStride)
    for (int x = 0; x < codes.cols(); x += kStride) {
      shown += !clip_policy::all_clipped(codes.at(0, y, x), codes.at(1, y, x), codes.at(2, y, x), usable);
      ++all;
    }
  return all > 0 ? static_cast<double>(shown) / all : 0;
}

bool less_noise(const Heading& a, const Heading& b) { return a.noise < b.noise; }

}  // namespace

TrackedPose::TrackedPose(std::optional<Intrinsics> intrinsics, WorkerPool& pool)
    : intrinsics_(intrinsics), tracks_(options_.tracks), fitter_(pool) {
  // points that drift into one cell leave others to new ones, so there are more of them than cells
  for (std::vector<double>* room : {&depths_, &trial_depths_, &errors_})
    room->reserve(2 * static_cast<std::size_t>(options_.tracks.points));
  fitter_.reserve(depths_.capacity());
}

const CameraPose& TrackedPose::estimate(const SeenFrame& seen) {
  blind_ = shown_share(seen.frame.codes) < options_.least_shown ? blind_ + 1 : 0;
  return next(seen.motion.to_previous, seen.motion.from_previous);
}

const CameraPose& TrackedPose::next(const FlowField& to_previous, const FlowField& from_previous) {
  if (from_previous.empty()) return pose_;
  const int rows = from_previous.vectors.rows(), cols = from_previous.vectors.cols();
  if (!started_) start(from_previous);
  track(from_previous);
  const CameraView view{rows, cols, lens_, T_camera_world_};
  tracks_.coast(view);
  if (depths_known_ == Depths::Unknown) tracks_.restart_when_thin();
  tracks_.seed(to_previous.confidence, view, depths_known_);
  pose_.T_world_camera = T_camera_world_.inverse();
  return pose_;
}

// The first flow gives the frame size; the first frame's points are placed where it can follow them.
void TrackedPose::start(const FlowField& from_previous) {
  const int rows = from_previous.vectors.rows(), cols = from_previous.vectors.cols();
  lens_ = intrinsics_.value_or(assumed_intrinsics(rows, cols));
  tracks_.seed(from_previous.confidence, {rows, cols, lens_, T_camera_world_}, depths_known_);
  started_ = true;
}

void TrackedPose::track(const FlowField& from_previous) {
  tracks_.follow(from_previous);
  if (tracks_.seen() < options_.fewest_points || blind_ > options_.longest_blind) return lose();

  tracks_.inverse_depths(depths_);
  trial_depths_ = depths_;
  const PoseFit turned = fitter_.fit(tracks_.points(), lens_, T_camera_world_,
                                     {.freedom = Freedom::Rotation, .steps = kTurnSteps}, trial_depths_);
  if (is_static(turned)) {
    tracks_.settle(lens_, T_camera_world_);
    note_velocity(T_camera_world_);
    return accept(T_camera_world_, Centre::Kept);
  }
  if (depths_known_ == Depths::Known)
    follow_translation(turned);
  else
    find_translation(turned);
}

// The depths fix the scale of the translation.
void TrackedPose::follow_translation(const PoseFit& turned) {
  const PoseFit moved =
      fitter_.fit(tracks_.points(), lens_, turned.T_camera_world, {.steps = kMoveSteps}, depths_);
  if (std::max(turned.inlier_share, moved.inlier_share) < options_.fewest_inliers) return lose();
  const bool was_moving = centre_ == Centre::Moved;
  if (turned.cost - moved.cost < (was_moving ? options_.translation_gain_on : options_.translation_gain)) {
    note_velocity(turned.T_camera_world);
    return accept(turned.T_camera_world, Centre::Kept);
  }
  tracks_.learn_noise(noise_across(tracks_.points(), depths_, lens_, moved.T_camera_world, errors_),
                      kNoiseLearning);
  tracks_.learn(depths_, lens_, moved.T_camera_world);
  // a position that catches up is not how fast the camera moves
  note_velocity(was_moving ? moved.T_camera_world : turned.T_camera_world);
  accept(moved.T_camera_world, Centre::Moved);
}

// No depth is known yet, all points were first seen from the world's origin. Of the headings that explain the
// flow best, the one with the least noise across the epipolar lines is chosen, once it stands out and the
// parallax is clear; until then the pose only rotates.
void TrackedPose::find_translation(const PoseFit& turned) {
  note_velocity(turned.T_camera_world);
  accept(turned.T_camera_world, Centre::Kept);
  const auto points = tracks_.points();
  const double unexplained_px = std::max(kUnexplained_px, kUnexplainedOfWay * tracks_.way_px(errors_));
  if (unexplained_share(points, lens_, turned.T_camera_world, unexplained_px) < options_.parallax_share)
    return;

  const std::vector<ScenePoint> some = thinned(points, kHeadingPoints);
  std::vector<Heading> headings = search_headings(some, lens_, turned.T_camera_world, kHeadingsTried);
  for (Heading& heading : headings) refine(some, lens_, kHeadingRounds, fitter_, heading);
  const auto best = std::min_element(headings.begin(), headings.end(), less_noise);
  const bool stands_out = std::all_of(headings.begin(), headings.end(), [&](const Heading& other) {
    return same_heading(*best, other) || best->noise < options_.heading_noise_ratio * other.noise;
  });
  if (!stands_out) return;

  Heading first{.T_camera_world = best->T_camera_world, .inverse_depths = depths_, .noise = best->noise};
  fitter_.fit(points, lens_, first.T_camera_world, {.freedom = Freedom::Nothing, .steps = kDepthSteps},
              first.inverse_depths);
  refine(points, lens_, 1, fitter_, first);
  const double clear_px =
      std::max(kClearParallax_px, kClearParallax_sigmas * first.noise * tracks_.noise_px());
  if (parallax_share(points, first, lens_, clear_px) < options_.parallax_share) return;
  tracks_.learn_noise(first.noise, 1);
  choose_unit(first);
  tracks_.learn(first.inverse_depths, lens_, first.T_camera_world);
  accept(first.T_camera_world, Centre::Moved);
}

// The median depth becomes the unit of length.
void TrackedPose::choose_unit(Heading& first) {
  constexpr double kLeastInverse = 1e-6;  // keeps the unit finite
  std::vector<double> sorted = first.inverse_depths;
  const double middle = std::max(median(sorted), kLeastInverse);
  first.T_camera_world.t *= middle;
  for (double& depth : first.inverse_depths) depth /= middle;
  depths_known_ = Depths::Known;
}

bool TrackedPose::is_static(const PoseFit& turned) const {
  if (tracks_.static_share(options_.static_px) < options_.static_share) return false;
  const Eigen::AngleAxisd turn(turned.T_camera_world.R * T_camera_world_.R.transpose());
  const Eigen::Vector3d angle = turn.angle() * turn.axis();
  const double drift_px =
      std::max(lens_.fx_px * std::hypot(angle.x(), angle.y()), 0.5 * lens_.cx_px * std::abs(angle.z()));
  return drift_px < options_.static_drift_px;
}

// Before the frame's pose is accepted: how the camera moved from the last one, which a lost frame continues.
void TrackedPose::note_velocity(const RigidTransform& T_camera_world) {
  T_camera_previous_ = T_camera_world * T_camera_world_.inverse();
}

void TrackedPose::accept(const RigidTransform& T_camera_world, Centre centre) {
  T_camera_world_ = T_camera_world;
  centre_ = centre;
  pose_.lost = false;
}

void TrackedPose::lose() {
  const Eigen::AngleAxisd turn(T_camera_previous_.R);
  T_camera_previous_.R = rotation(options_.velocity_decay * turn.angle() * turn.axis());
  T_camera_previous_.t *= options_.velocity_decay;
  T_camera_world_ = T_camera_previous_ * T_camera_world_;
  T_camera_world_.R = orthonormal(T_camera_world_.R);
  tracks_.mark_all_unseen();
  pose_.lost = true;
}

}  // namespace hdrcam
