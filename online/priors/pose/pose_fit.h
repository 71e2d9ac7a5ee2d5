// The pose of a camera from points of the scene with uncertain depths: a robust maximum a posteriori fit of
// the pose and all inverse depths together. A point is a ray from where it was first seen; its inverse depth
// d has a Gaussian prior, so that a point with known depth fixes the camera's position (and the scale), one
// with unknown depth still gives its epipolar constraint, and at zero baseline every point gives the
// rotation. Minimises
//   sum_i rho(|pi(T_camera_world, d_i) - seen_i|^2 / sigma_i^2) + information_i (d_i - prior_i)^2
// with Geman-McClure's rho, by Gauss-Newton with the depths eliminated (Schur complement): 6 unknowns per
// step. The functions are reentrant, a PoseFitter is thread-bound.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "hal/core/frame.h"
#include "hal/core/geometry.h"
#include "hal/core/worker_pool.h"

namespace hdrcam {

struct ScenePoint {
  Eigen::Vector3d origin_world;     // the camera centre from which it was first seen
  Eigen::Vector3d direction_world;  // through its pixel there; camera z of that view = 1
  double inverse_depth = 1;         // prior mean, along that direction
  double information = 1;           // 1 / variance of the prior
  Eigen::Vector2d seen_px;          // in the current frame
  double sigma_px = 0.3;            // of that position
  bool seen = true;                 // takes part in the fit
};

// The unknowns besides the inverse depths.
enum class Freedom { Nothing, Rotation, RotationAndTranslation };

struct PoseFit {
  RigidTransform T_camera_world;
  double cost = 0;          // of the whole problem, in squared sigmas
  double inlier_share = 0;  // share of the seen points with residual under kInlierSigmas
  int seen = 0;
};

constexpr double kInlierSigmas = 4;

struct FitOptions {
  Freedom freedom = Freedom::RotationAndTranslation;
  int steps = 8;           // of Gauss-Newton
  double noise_scale = 1;  // all sigmas times this
  // The robust kernel at the first step: wide, so that a poor start still uses all points.
  double widest_sigmas = 12;
};

struct EliminatedDepth;  // both of pose_fit.cpp
struct PoseSums;

// Fits one pose after the other in the same memory. The pool belongs to the caller's thread and outlives it.
class PoseFitter {
 public:
  explicit PoseFitter(WorkerPool& pool);
  ~PoseFitter();
  // Allocates for up to so many points; fit() then allocates nothing.
  void reserve(std::size_t points);

  // Improves a start pose; with no steps it only computes its cost. inverse_depths: [points] start on entry
  // (prior means), the fitted values on return. The result does not depend on the number of threads.
  PoseFit fit(std::span<const ScenePoint> points, const Intrinsics& lens,
              const RigidTransform& T_camera_world, const FitOptions& options,
              std::span<double> inverse_depths);

 private:
  template <class Body>
  PoseSums sum_over(std::span<const ScenePoint> points, Body&& body);

  WorkerPool& pool_;
  std::vector<EliminatedDepth> eliminated_;  // [points]
  std::vector<PoseSums> parts_;
};

// The noise that no depth can explain: the median residual across the epipolar lines, as a standard deviation
// in sigmas. `errors` is scratch memory.
double noise_across(std::span<const ScenePoint> points, std::span<const double> inverse_depths,
                    const Intrinsics& lens, const RigidTransform& T_camera_world,
                    std::vector<double>& errors);

// Squared residual in sigmas of one point, and how strongly its pixel depends on the inverse depth.
struct PointResidual {
  Eigen::Vector2d px;                 // pi - seen
  Eigen::Vector2d per_inverse_depth;  // d px / d inverse depth
  double squared_sigmas = 0;
};
// None where the point is not in front of the camera.
std::optional<PointResidual> point_residual(const ScenePoint& point, double inverse_depth,
                                            const Intrinsics& lens, const RigidTransform& T_camera_world);

}  // namespace hdrcam
