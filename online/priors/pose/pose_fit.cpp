#include "online/priors/pose/pose_fit.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "hal/core/check.h"
#include "hal/core/median.h"

namespace hdrcam {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Matrix23 = Eigen::Matrix<double, 2, 3>;
using Matrix26 = Eigen::Matrix<double, 2, 6>;

constexpr double kNearestZ = 1e-3;       // of the ray's z in the posed camera: behind it there is no pixel
constexpr double kRobustSigmas = 3;      // the kernel's width at the end
constexpr double kGaussianMad = 1.4826;  // standard deviation / median of the absolute value
constexpr double kSmallestStep = 1e-9;   // radians and lengths: converged

double robust_cost(double squared, double width) {
  return squared * width * width / (width * width + squared);
}
double robust_weight(double squared, double width) {
  const double w = width * width / (width * width + squared);
  return w * w;
}

// Y = R a + d (R o + t): the point in the camera, scaled by its inverse depth, so that d = 0 is at infinity.
struct Projection {
  Eigen::Vector3d y;
  Eigen::Vector3d baseline;  // dY / dd
  Matrix23 per_y;            // d px / dY
  Eigen::Vector2d px;
};

bool project(const ScenePoint& point, double inverse_depth, const Intrinsics& lens, const RigidTransform& T,
             Projection& out) {
  out.baseline = T.R * point.origin_world + T.t;
  out.y = T.R * point.direction_world + inverse_depth * out.baseline;
  if (!(out.y.z() > kNearestZ)) return false;
  const double z = 1 / out.y.z();
  const double x = out.y.x() * z, y = out.y.y() * z;
  out.px = {lens.fx_px * x + lens.cx_px, lens.fy_px * y + lens.cy_px};
  out.per_y << lens.fx_px * z, 0, -lens.fx_px * z * x, 0, lens.fy_px * z, -lens.fy_px * z * y;
  return true;
}

// The normal equations of one linearisation.
struct Linearised {
  Matrix6 H = Matrix6::Zero();
  Vector6 g = Vector6::Zero();
};

struct PointTerms {
  Matrix26 per_pose;  // d px / d (rotation, translation)
  Eigen::Vector2d per_depth;
  Eigen::Vector2d px;
  double weight = 0;  // robust / sigma^2
  double offset = 0;  // d - prior
};

bool linearise(const ScenePoint& point, double d, const Intrinsics& lens, const RigidTransform& T,
               double scale, double width, PointTerms& terms) {
  Projection p;
  if (!project(point, d, lens, T, p)) return false;
  terms.px = p.px - point.seen_px;
  terms.per_pose.leftCols<3>() = -p.per_y * cross_matrix(p.y);
  terms.per_pose.rightCols<3>() = p.per_y * d;
  terms.per_depth = p.per_y * p.baseline;
  const double precision = 1 / (point.sigma_px * point.sigma_px * scale * scale);
  terms.weight = precision * robust_weight(terms.px.squaredNorm() * precision, width);
  terms.offset = d - point.inverse_depth;
  return true;
}

// Adds one point with its depth eliminated. Returns what gives the depth's step once the pose's is known.
EliminatedDepth accumulate(const ScenePoint& point, const PointTerms& q, Linearised& sum) {
  const Matrix26 weighted = q.weight * q.per_pose;
  EliminatedDepth depth;
  depth.curvature = q.weight * q.per_depth.squaredNorm() + point.information;
  depth.gradient = q.weight * q.per_depth.dot(q.px) + point.information * q.offset;
  depth.coupling = weighted.transpose().lazyProduct(q.per_depth);
  const Vector6 scaled = depth.coupling / depth.curvature;
  sum.H += weighted.transpose().lazyProduct(q.per_pose) - depth.coupling.lazyProduct(scaled.transpose());
  sum.g += weighted.transpose().lazyProduct(q.px) - scaled * depth.gradient;
  return depth;
}

Vector6 solve(Linearised& sum, Freedom freedom) {
  if (freedom == Freedom::Nothing) return Vector6::Zero();
  if (freedom == Freedom::Rotation) {
    sum.H.bottomRows<3>().setZero(), sum.H.rightCols<3>().setZero();
    sum.H.bottomRightCorner<3, 3>().setIdentity();
    sum.g.tail<3>().setZero();
  }
  sum.H.diagonal() *= 1 + 1e-6;
  sum.H.diagonal().array() += 1e-6;
  const Vector6 step = -sum.H.ldlt().solve(sum.g);
  return step.allFinite() ? step : Vector6::Zero();
}

double total_cost(std::span<const ScenePoint> points, std::span<const double> inverse_depths,
                  const Intrinsics& lens, double scale, PoseFit& fit) {
  double cost = 0;
  int inliers = 0;
  fit.seen = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].seen) continue;
    ++fit.seen;
    PointResidual r;
    const bool in_front = point_residual(points[i], inverse_depths[i], lens, fit.T_camera_world, r);
    const double squared = in_front ? r.squared_sigmas / (scale * scale) : 1e9;
    inliers += squared < kInlierSigmas * kInlierSigmas;
    const double offset = inverse_depths[i] - points[i].inverse_depth;
    cost += robust_cost(squared, kRobustSigmas) + points[i].information * offset * offset;
  }
  fit.inlier_share = fit.seen > 0 ? static_cast<double>(inliers) / fit.seen : 0;
  return cost;
}

}  // namespace

bool point_residual(const ScenePoint& point, double inverse_depth, const Intrinsics& lens,
                    const RigidTransform& T, PointResidual& residual) {
  Projection p;
  if (!project(point, inverse_depth, lens, T, p)) return false;
  residual.px = p.px - point.seen_px;
  residual.per_inverse_depth = p.per_y * p.baseline;
  residual.squared_sigmas = residual.px.squaredNorm() / (point.sigma_px * point.sigma_px);
  residual.camera_z = p.y.z();
  return true;
}

double noise_across(std::span<const ScenePoint> points, std::span<const double> inverse_depths,
                    const Intrinsics& lens, const RigidTransform& T_camera_world,
                    std::vector<double>& errors) {
  errors.clear();
  for (std::size_t i = 0; i < points.size(); ++i) {
    PointResidual r;
    if (!points[i].seen || !point_residual(points[i], inverse_depths[i], lens, T_camera_world, r)) continue;
    const double along = r.per_inverse_depth.norm();
    const double across = r.per_inverse_depth.x() * r.px.y() - r.per_inverse_depth.y() * r.px.x();
    if (along > 0) errors.push_back(std::abs(across) / (along * points[i].sigma_px));
  }
  return kGaussianMad * median(errors);
}

PoseFit fit_pose(std::span<const ScenePoint> points, const Intrinsics& lens,
                 const RigidTransform& T_camera_world, const FitOptions& options,
                 std::span<double> inverse_depths, std::vector<EliminatedDepth>& room) {
  CHECK_EQ(points.size(), inverse_depths.size());
  PoseFit fit;
  fit.T_camera_world = T_camera_world;
  RigidTransform& T = fit.T_camera_world;
  for (int step = 0; step < options.steps; ++step) {
    const double width = std::max(kRobustSigmas, options.widest_sigmas * std::pow(0.5, step));
    Linearised sum;
    PointTerms terms;
    room.clear();
    for (std::size_t i = 0; i < points.size(); ++i)
      if (points[i].seen &&
          linearise(points[i], inverse_depths[i], lens, T, options.noise_scale, width, terms)) {
        room.push_back(accumulate(points[i], terms, sum));
        room.back().point = i;
      }
    const Vector6 move = solve(sum, options.freedom);
    for (const EliminatedDepth& depth : room) {
      double& d = inverse_depths[depth.point];
      d = std::max(0.0, d - (depth.gradient + depth.coupling.dot(move)) / depth.curvature);
    }
    const Eigen::Matrix3d turn = rotation(move.head<3>());
    T = {turn * T.R, turn * T.t + move.tail<3>()};
    if (options.freedom != Freedom::Nothing && width == kRobustSigmas && move.norm() < kSmallestStep) break;
  }
  T.R = orthonormal(T.R);
  fit.cost = total_cost(points, inverse_depths, lens, options.noise_scale, fit);
  return fit;
}

}  // namespace hdrcam
