#include "firmware_host/film/steady_path.h"

#include <Eigen/Geometry>
#include <cmath>

#include "hal/core/check.h"

namespace hdrcam {

void SteadyPath::add(double time_s, const RigidTransform& T_world_camera, int world, Is is) {
  poses_.push_back({time_s, T_world_camera, world, is});
}

void SteadyPath::forget_before(double time_s) {
  while (poses_.size() > 1 && poses_.front().time_s < time_s - kReach_s) poses_.pop_front();
}

RigidTransform SteadyPath::at(double time_s) const {
  HDRCAM_CHECK(!poses_.empty());
  constexpr double kSigma_s = kReach_s / 2;
  const Pose* nearest = &poses_.front();
  const auto comes_before = [&](const Pose& a, const Pose& b) {
    if (a.is != b.is) return a.is == Is::Posed;
    return std::abs(a.time_s - time_s) < std::abs(b.time_s - time_s);
  };
  for (const Pose& pose : poses_)
    if (comes_before(pose, *nearest)) nearest = &pose;
  const Eigen::Quaterniond middle(nearest->T_world_camera.R);
  Eigen::Vector3d place = Eigen::Vector3d::Zero(), turn = Eigen::Vector3d::Zero();
  double sum = 0;
  for (const Pose& pose : poses_) {
    if (pose.world != nearest->world || pose.is != nearest->is) continue;
    const double away = (pose.time_s - time_s) / kSigma_s;
    if (std::abs(away) > kReach_s / kSigma_s && &pose != nearest) continue;
    const double weight = std::exp(-0.5 * away * away) + 1e-12;
    const Eigen::AngleAxisd difference(
        Eigen::Quaterniond(middle.conjugate() * Eigen::Quaterniond(pose.T_world_camera.R)));
    place += weight * pose.T_world_camera.t;
    turn += weight * difference.angle() * difference.axis();
    sum += weight;
  }
  return {orthonormal(middle.toRotationMatrix() * rotation(turn / sum)), place / sum};
}

}  // namespace hdrcam
