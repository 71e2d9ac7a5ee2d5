#include "online/priors/pose/pose_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "hal/core/check.h"
#include "hal/core/median.h"

namespace hdrcam {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

// What the equation of a point's depth leaves once the pose is solved for.
struct EliminatedDepth {
  Vector6 coupling = Vector6::Zero();  // with the pose's step
  double gradient = 0, curvature = 1;
};

// The sums over a part of the points.
struct PoseSums {
  Matrix6 H = Matrix6::Zero();
  Vector6 g = Vector6::Zero();
  double cost = 0;
  int seen = 0, inliers = 0;
};

namespace {

using Matrix23 = Eigen::Matrix<double, 2, 3>;
using Matrix26 = Eigen::Matrix<double, 2, 6>;

constexpr double kNearestZ = 1e-3;      // of the ray's z in the posed camera: behind it there is no pixel
constexpr double kRobustSigmas = 3;     // the kernel's width at the end
constexpr double kSmallestStep = 1e-6;  // radians and lengths: converged
constexpr double kBehind = 1e9;         // squared sigmas of a point behind the camera
constexpr double kDamping = 1e-6;       // of the normal equations: they can be solved without a point, too
constexpr int kPartPoints = 64;         // that a thread takes at once

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

// None where the point is not in front of the camera.
std::optional<Projection> project(const ScenePoint& point, double inverse_depth, const Intrinsics& lens,
                                  const RigidTransform& T) {
  Projection out;
  out.baseline = T.R * point.origin_world + T.t;
  out.y = T.R * point.direction_world + inverse_depth * out.baseline;
  if (!(out.y.z() > kNearestZ)) return std::nullopt;
  const double z = 1 / out.y.z();
  const double x = out.y.x() * z, y = out.y.y() * z;
  out.px = {lens.fx_px * x + lens.cx_px, lens.fy_px * y + lens.cy_px};
  out.per_y << lens.fx_px * z, 0, -lens.fx_px * z * x, 0, lens.fy_px * z, -lens.fy_px * z * y;
  return out;
}

struct PointTerms {
  Matrix26 per_pose;  // d px / d (rotation, translation)
  Eigen::Vector2d per_depth;
  Eigen::Vector2d px;
  double weight = 0;  // robust / sigma^2
  double offset = 0;  // d - prior
};

std::optional<PointTerms> linearise(const ScenePoint& point, double d, const Intrinsics& lens,
                                    const RigidTransform& T, double scale, double width) {
  const std::optional<Projection> p = project(point, d, lens, T);
  if (!p) return std::nullopt;
  PointTerms terms;
  terms.px = p->px - point.seen_px;
  terms.per_pose.leftCols<3>() = -p->per_y * cross_matrix(p->y);
  terms.per_pose.rightCols<3>() = p->per_y * d;
  terms.per_depth = p->per_y * p->baseline;
  const double precision = 1 / (point.sigma_px * point.sigma_px * scale * scale);
  terms.weight = precision * robust_weight(terms.px.squaredNorm() * precision, width);
  terms.offset = d - point.inverse_depth;
  return terms;
}

// Adds one point with its depth eliminated. Returns what gives the depth's step once the pose's is known.
EliminatedDepth accumulate(const ScenePoint& point, const PointTerms& q, PoseSums& sums) {
  const Matrix26 weighted = q.weight * q.per_pose;
  EliminatedDepth depth;
  depth.curvature = q.weight * q.per_depth.squaredNorm() + point.information;
  depth.gradient = q.weight * q.per_depth.dot(q.px) + point.information * q.offset;
  depth.coupling = weighted.transpose().lazyProduct(q.per_depth);
  const Vector6 scaled = depth.coupling / depth.curvature;
  sums.H += weighted.transpose().lazyProduct(q.per_pose) - depth.coupling.lazyProduct(scaled.transpose());
  sums.g += weighted.transpose().lazyProduct(q.px) - scaled * depth.gradient;
  return depth;
}

Vector6 solve(PoseSums& sums, Freedom freedom) {
  if (freedom == Freedom::Nothing) return Vector6::Zero();
  if (freedom == Freedom::Rotation) {
    sums.H.bottomRows<3>().setZero(), sums.H.rightCols<3>().setZero();
    sums.H.bottomRightCorner<3, 3>().setIdentity();
    sums.g.tail<3>().setZero();
  }
  sums.H.diagonal() *= 1 + kDamping;
  sums.H.diagonal().array() += kDamping;
  const Vector6 step = -sums.H.ldlt().solve(sums.g);
  return step.allFinite() ? step : Vector6::Zero();
}

}  // namespace

std::optional<PointResidual> point_residual(const ScenePoint& point, double inverse_depth,
                                            const Intrinsics& lens, const RigidTransform& T) {
  const std::optional<Projection> p = project(point, inverse_depth, lens, T);
  if (!p) return std::nullopt;
  PointResidual residual;
  residual.px = p->px - point.seen_px;
  residual.per_inverse_depth = p->per_y * p->baseline;
  residual.squared_sigmas = residual.px.squaredNorm() / (point.sigma_px * point.sigma_px);
  return residual;
}

double noise_across(std::span<const ScenePoint> points, std::span<const double> inverse_depths,
                    const Intrinsics& lens, const RigidTransform& T_camera_world,
                    std::vector<double>& errors) {
  errors.clear();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].seen) continue;
    const auto r = point_residual(points[i], inverse_depths[i], lens, T_camera_world);
    if (!r) continue;
    const double along = r->per_inverse_depth.norm();
    const double across = r->per_inverse_depth.x() * r->px.y() - r->per_inverse_depth.y() * r->px.x();
    if (along > 0) errors.push_back(std::abs(across) / (along * points[i].sigma_px));
  }
  return kSigmaPerMad * median(errors);
}

PoseFitter::PoseFitter(WorkerPool& pool) : pool_(pool) {}
PoseFitter::~PoseFitter() = default;

void PoseFitter::reserve(std::size_t points) {
  eliminated_.reserve(points);
  parts_.reserve(points / kPartPoints + 1);
}

// Calls body(i, sums) for the points that were seen; the parts are summed in their order.
template <class Body>
PoseSums PoseFitter::sum_over(std::span<const ScenePoint> points, Body&& body) {
  const std::size_t parts = (points.size() + kPartPoints - 1) / kPartPoints;
  parts_.assign(parts, {});
  pool_.for_each(static_cast<int>(parts), [&](int part) {
    PoseSums sums;
    const std::size_t begin = static_cast<std::size_t>(part) * kPartPoints,
                      end = std::min(points.size(), begin + kPartPoints);
    for (std::size_t i = begin; i < end; ++i)
      if (points[i].seen) body(i, sums);
    parts_[static_cast<std::size_t>(part)] = sums;
  });
  PoseSums all;
  for (const PoseSums& part : parts_) {
    all.H += part.H, all.g += part.g;
    all.cost += part.cost, all.seen += part.seen, all.inliers += part.inliers;
  }
  return all;
}

PoseFit PoseFitter::fit(std::span<const ScenePoint> points, const Intrinsics& lens,
                        const RigidTransform& T_camera_world, const FitOptions& options,
                        std::span<double> inverse_depths) {
  HDRCAM_CHECK_EQ(points.size(), inverse_depths.size());
  PoseFit fit;
  fit.T_camera_world = T_camera_world;
  RigidTransform& T = fit.T_camera_world;
  eliminated_.assign(points.size(), {});
  Vector6 move = Vector6::Zero();
  const auto depth_after_move = [&](std::size_t i) {
    const EliminatedDepth& depth = eliminated_[i];
    double& d = inverse_depths[i];
    return d = std::max(0.0, d - (depth.gradient + depth.coupling.dot(move)) / depth.curvature);
  };
  for (int step = 0; step < options.steps; ++step) {
    const double width = std::max(kRobustSigmas, options.widest_sigmas * std::pow(0.5, step));
    PoseSums sums = sum_over(points, [&](std::size_t i, PoseSums& some) {
      const auto terms = linearise(points[i], depth_after_move(i), lens, T, options.noise_scale, width);
      eliminated_[i] = terms ? accumulate(points[i], *terms, some) : EliminatedDepth();
    });
    move = solve(sums, options.freedom);
    const Eigen::Matrix3d turn = rotation(move.head<3>());
    T = {turn * T.R, turn * T.t + move.tail<3>()};
    if (options.freedom != Freedom::Nothing && width == kRobustSigmas && move.norm() < kSmallestStep) break;
  }
  T.R = orthonormal(T.R);
  const double scale2 = options.noise_scale * options.noise_scale;
  const PoseSums sums = sum_over(points, [&](std::size_t i, PoseSums& some) {
    const double d = depth_after_move(i);
    const auto r = point_residual(points[i], d, lens, T);
    const double squared = r ? r->squared_sigmas / scale2 : kBehind;
    const double offset = d - points[i].inverse_depth;
    some.cost += robust_cost(squared, kRobustSigmas) + points[i].information * offset * offset;
    some.inliers += squared < kInlierSigmas * kInlierSigmas;
    ++some.seen;
  });
  fit.cost = sums.cost;
  fit.seen = sums.seen;
  fit.inlier_share = sums.seen > 0 ? static_cast<double>(sums.inliers) / sums.seen : 0;
  return fit;
}

}  // namespace hdrcam
