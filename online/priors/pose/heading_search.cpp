#include "online/priors/pose/heading_search.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "hal/core/median.h"

namespace hdrcam {
namespace {

constexpr int kHeadings = 128;              // on the half sphere: about 12 degrees apart
constexpr double kDifferent = 0.94;         // cosine between two headings that count as different
constexpr int kRounds = 4;                  // of reweighting
constexpr double kKernel_medians = 4;       // width of the robust kernel
constexpr double kLeastError = 1e-4;        // focal lengths: below it all headings fit perfectly
constexpr double kShortestEpipolar = 0.03;  // closer to the epipole the direction is undefined
constexpr double kNearestZ = 0.1;           // of a ray in the turned camera: beside it there is no flow
constexpr double kLeastParallax = 1e-6;     // keeps the unit of length finite

// A point's flow once the rotation is taken out, in focal lengths.
struct Parallax {
  std::size_t index;
  double x, y;                           // the position that the rotation alone predicts
  Eigen::Vector2d flow;                  // from there to where it was seen
  Eigen::Matrix<double, 2, 3> per_turn;  // d flow / d small rotation
  double sigma;
};

std::vector<Parallax> parallaxes(std::span<const ScenePoint> points, const Intrinsics& lens,
                                 const RigidTransform& turned) {
  std::vector<Parallax> all;
  all.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d a = turned.R * points[i].direction_world;
    if (!points[i].seen || a.z() < kNearestZ) continue;
    Parallax p{.index = i, .x = a.x() / a.z(), .y = a.y() / a.z(), .flow = {}, .per_turn = {}, .sigma = 0};
    p.flow = {(points[i].seen_px.x() - lens.cx_px) / lens.fx_px - p.x,
              (points[i].seen_px.y() - lens.cy_px) / lens.fy_px - p.y};
    p.per_turn << -p.x * p.y, 1 + p.x * p.x, -p.y, -1 - p.y * p.y, p.x * p.y, p.x;
    p.sigma = points[i].sigma_px / lens.fx_px;
    all.push_back(p);
  }
  return all;
}

// i-th of a spiral that covers the half sphere z >= 0 evenly
Eigen::Vector3d heading(int i) {
  const double z = (i + 0.5) / kHeadings;
  const double angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
  const double r = std::sqrt(1 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

// The direction in which a translation along the heading moves a point, times its inverse depth.
Eigen::Vector2d epipolar_line(const Parallax& p, const Eigen::Vector3d& direction) {
  return {direction.x() - p.x * direction.z(), direction.y() - p.y * direction.z()};
}

struct Candidate {
  Eigen::Vector3d direction;
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();
  double cost = 0;     // median error across the epipolar lines, focal lengths
  double forward = 0;  // how many points are in front rather than behind, softly counted
};

// The best small rotation for one heading, its cost, and the direction along the heading for which the points
// are in front.
Candidate explain(const std::vector<Parallax>& points, const Eigen::Vector3d& direction,
                  std::vector<double>& errors) {
  constexpr double kRegular = 1e-9;  // of the normal equations: they can be solved without a point, too
  Candidate found{.direction = direction, .turn = Eigen::Vector3d::Zero()};
  double width = HUGE_VAL;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix3d H = kRegular * Eigen::Matrix3d::Identity();
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
    found.forward = 0;
    errors.clear();
    for (const Parallax& p : points) {
      const Eigen::Vector2d line = epipolar_line(p, direction);
      const double length = line.norm();
      if (length < kShortestEpipolar) continue;
      const Eigen::Vector2d across(-line.y() / length, line.x() / length);
      const Eigen::RowVector3d row = across.transpose() * p.per_turn;
      const double error = across.dot(p.flow) - row * found.turn;
      const double kernel = 1 / (1 + error * error / (width * width));
      const double weight = kernel * kernel;
      errors.push_back(std::abs(error));
      found.forward += weight * std::tanh(line.dot(p.flow - p.per_turn * found.turn) / (length * p.sigma));
      H.noalias() += weight * row.transpose() * row;
      g.noalias() += weight * row.transpose() * error;
    }
    found.cost = median(errors);
    width = kKernel_medians * std::max(found.cost, kLeastError);
    if (round + 1 < kRounds) found.turn += H.ldlt().solve(g);
  }
  if (found.forward < 0) found.direction = -direction;
  return found;
}

// A small turn moves all points of a narrow view alike, as a translation does: with another turn the same
// flow is that of the opposite heading, near for far. What the turn does besides tells which it is, once both
// are fitted. None where the heading is too much along the view: no turn looks like it.
std::optional<Candidate> mirrored(const std::vector<Parallax>& points, const Candidate& found,
                                  std::vector<double>& along) {
  constexpr double kSideways = 0.5;
  constexpr double kFarthest = 0.95;  // so much of the points' flow along the heading is turn, at most
  const double sideways = found.direction.head<2>().norm();
  if (sideways < kSideways) return std::nullopt;
  along.clear();
  for (const Parallax& p : points) {
    const Eigen::Vector2d line = epipolar_line(p, found.direction);
    if (line.norm() >= kShortestEpipolar)
      along.push_back(line.dot(p.flow - p.per_turn * found.turn) / line.norm());
  }
  if (along.empty()) return std::nullopt;
  const auto most =
      along.begin() + static_cast<std::ptrdiff_t>(kFarthest * static_cast<double>(along.size() - 1));
  std::nth_element(along.begin(), most, along.end());
  Candidate opposite = found;
  opposite.direction = -found.direction;
  opposite.turn += *most / sideways * Eigen::Vector3d(-found.direction.y(), found.direction.x(), 0);
  return opposite;
}

Heading as_pose(const Candidate& found, const std::vector<Parallax>& parallax, std::size_t points,
                const RigidTransform& turned) {
  constexpr double kShortest2 = 1e-4;  // squared: next to the epipole a depth stays finite
  std::vector<double> depths;          // for a translation of length 1
  for (const Parallax& p : parallax) {
    const Eigen::Vector2d line = epipolar_line(p, found.direction);
    depths.push_back(
        std::max(0.0, line.dot(p.flow - p.per_turn * found.turn) / std::max(line.squaredNorm(), kShortest2)));
  }
  std::vector<double> sorted = depths;
  const double unit = std::max(median(sorted), kLeastParallax);
  Heading result{.T_camera_world = {}, .inverse_depths = std::vector<double>(points, 1.0)};
  for (std::size_t k = 0; k < parallax.size(); ++k)
    result.inverse_depths[parallax[k].index] = depths[k] / unit;
  const Eigen::Matrix3d turn = rotation(found.turn);
  result.T_camera_world = {turn * turned.R, turn * turned.t + unit * found.direction};
  return result;
}

}  // namespace

std::vector<Heading> search_headings(std::span<const ScenePoint> points, const Intrinsics& lens,
                                     const RigidTransform& turned, int count) {
  const std::vector<Parallax> parallax = parallaxes(points, lens, turned);
  std::vector<Candidate> candidates;
  candidates.reserve(kHeadings);
  std::vector<double> errors;
  for (int i = 0; i < kHeadings; ++i) candidates.push_back(explain(parallax, heading(i), errors));
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const auto& a, const auto& b) { return a.cost < b.cost; });

  std::vector<Candidate> chosen;
  for (const Candidate& candidate : candidates) {
    const bool different = std::none_of(chosen.begin(), chosen.end(), [&](const Candidate& other) {
      return std::abs(other.direction.dot(candidate.direction)) > kDifferent;
    });
    if (different) chosen.push_back(candidate);
    if (static_cast<int>(chosen.size()) == count) break;
  }
  std::vector<Heading> headings;
  headings.reserve(2 * chosen.size());
  for (const Candidate& candidate : chosen) {
    headings.push_back(as_pose(candidate, parallax, points.size(), turned));
    if (const auto opposite = mirrored(parallax, candidate, errors))
      headings.push_back(as_pose(*opposite, parallax, points.size(), turned));
  }
  return headings;
}

}  // namespace hdrcam
