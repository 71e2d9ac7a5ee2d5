#include "online/priors/pose/pose_prior.h"

#include <spdlog/spdlog.h>

#include <cmath>
#include <numbers>

#include "online/priors/pose/known_pose.h"
#include "online/priors/pose/tracked_pose.h"

namespace hdrcam {
namespace {

constexpr double kAssumedFieldOfView_deg = 55;

}  // namespace

Intrinsics assumed_intrinsics(int rows, int cols) {
  const double focal_px = 0.5 * cols / std::tan(0.5 * kAssumedFieldOfView_deg * std::numbers::pi / 180);
  return {.fx_px = focal_px, .fy_px = focal_px, .cx_px = 0.5 * cols, .cy_px = 0.5 * rows};
}

std::unique_ptr<PosePrior> make_pose_prior(PoseKind kind, const CameraFacts& camera, bool has_poses,
                                           WorkerPool& pool) {
  if (kind == PoseKind::Fixed) return std::make_unique<FixedPose>();
  if (kind == PoseKind::Given && has_poses) return std::make_unique<GivenPose>();
  return std::make_unique<TrackedPose>(camera.intrinsics, pool);
}

void warn_of_assumed_lens(const CameraFacts& camera) {
  spdlog::warn("{} does not report its focal length; assuming {} degrees horizontally",
               camera.name.empty() ? "the camera" : camera.name, kAssumedFieldOfView_deg);
}

}  // namespace hdrcam
