#include "online/priors/pose/point_tracks.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "hal/core/median.h"

namespace hdrcam {
namespace {

constexpr double kTypicalInverseDepth = 1;  // the unit of length is the median depth
constexpr double kSettle = 0.02;            // per frame
constexpr double kForget = 0.98;            // of the information, per frame: keeps the map correctable
constexpr double kBestRelative = 0.02;      // lower limit of an inverse depth's relative uncertainty
constexpr int kMargin_px = 2;
constexpr double kNearestZ = 0.1;                  // of a point over its inverse depth, in the camera
constexpr double kLeastInverse = 0.1;              // of a point whose uncertainty is limited, in typical ones
constexpr double kLeastOfNew = 0.3;                // of a point whose prior's width is set, likewise
constexpr double kCellMargin = 0.2;                // of a cell, on either side: no point is placed there
constexpr double kJittered = 1 - 2 * kCellMargin;  // of a cell, between them
constexpr double kReach2 = 9;                      // squared standard deviations: farther points tell nothing
constexpr double kTypicalWeight = 1e-3;            // of the typical depth among those of the neighbours
constexpr double kReadWeight = 0.01;               // of a corner of a pixel whose confidence counts

// 0..1, from a hash of three integers (xxhash's avalanche)
double jitter(unsigned a, unsigned b, unsigned c) {
  std::uint32_t h = a * 2654435761u + b * 2246822519u + c * 3266489917u;
  h = (h ^ (h >> 15)) * 2246822519u;
  h = (h ^ (h >> 13)) * 3266489917u;
  return static_cast<double>(h ^ (h >> 16)) / 4294967296.0;
}

struct FlowSample {
  Eigen::Vector2d vector;
  float confidence = 0;
  float disagreement_px = 0;
};

// Bilinear at a point (pixel centres at +0.5). None outside, and where it is not finite.
std::optional<FlowSample> sample_flow(const FlowField& flow, const Eigen::Vector2d& px) {
  const double x = px.x() - 0.5, y = px.y() - 0.5;
  const int cols = flow.vectors.cols(), rows = flow.vectors.rows();
  if (!(x >= 0 && y >= 0 && x <= cols - 1 && y <= rows - 1)) return std::nullopt;
  const int x0 = std::min(static_cast<int>(x), cols - 2), y0 = std::min(static_cast<int>(y), rows - 2);
  if (x0 < 0 || y0 < 0) return std::nullopt;
  const double fx = x - x0, fy = y - y0;
  const double weights[4] = {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy};
  FlowSample sample{.vector = Eigen::Vector2d::Zero(), .confidence = 1};
  for (int channel = 0; channel < 2; ++channel) {
    const float* upper = flow.vectors.row(channel, y0) + x0;
    const float* lower = flow.vectors.row(channel, y0 + 1) + x0;
    const float corners[4] = {upper[0], upper[1], lower[0], lower[1]};
    for (int k = 0; k < 4; ++k) sample.vector[channel] += weights[k] * static_cast<double>(corners[k]);
    const auto [least, most] = std::minmax_element(corners, corners + 4);
    sample.disagreement_px = std::max(sample.disagreement_px, *most - *least);
  }
  for (int k = 0; k < 4; ++k)
    if (weights[k] > kReadWeight)
      sample.confidence = std::min(sample.confidence, flow.confidence.at(0, y0 + k / 2, x0 + k % 2));
  if (!sample.vector.allFinite()) return std::nullopt;
  return sample;
}

// So far inside the picture that the flow can be read.
bool is_inside(const Eigen::Vector2d& px, int rows, int cols) {
  return px.x() >= kMargin_px && px.y() >= kMargin_px && px.x() <= cols - kMargin_px &&
         px.y() <= rows - kMargin_px;
}

Eigen::Vector3d ray(const Intrinsics& lens, const Eigen::Vector2d& px) {
  return {(px.x() - lens.cx_px) / lens.fx_px, (px.y() - lens.cy_px) / lens.fy_px, 1};
}

}  // namespace

void PointTracks::remove(std::size_t i) {
  points_[i] = points_.back(), points_.pop_back();
  histories_[i] = histories_.back(), histories_.pop_back();
}

void PointTracks::follow(const FlowField& from_previous) {
  for (std::size_t i = 0; i < points_.size(); ++i) {
    ScenePoint& point = points_[i];
    const auto flow = sample_flow(from_previous, point.seen_px);
    point.seen = flow && flow->confidence >= options_.least_confidence &&
                 flow->disagreement_px <= options_.flow_disagreement_px;
    if (!point.seen) continue;
    point.seen_px += flow->vector;
    histories_[i].moved_px = flow->vector.norm();
    ++histories_[i].age;
    point.sigma_px = sigma_of(histories_[i]);
  }
}

double PointTracks::static_share(double px) const {
  int static_points = 0, all = 0;
  for (std::size_t i = 0; i < points_.size(); ++i)
    if (points_[i].seen) ++all, static_points += histories_[i].moved_px < px;
  return all > 0 ? static_cast<double>(static_points) / all : 0;
}

double PointTracks::way_px(std::vector<double>& ways) const {
  ways.clear();
  for (std::size_t i = 0; i < points_.size(); ++i)
    if (points_[i].seen) ways.push_back((points_[i].seen_px - histories_[i].first_px).norm());
  return median(ways);
}

int PointTracks::seen() const {
  return static_cast<int>(
      std::count_if(points_.begin(), points_.end(), [](const auto& p) { return p.seen; }));
}

void PointTracks::settle(const Intrinsics& lens, const RigidTransform& T_camera_world) {
  for (std::size_t i = 0; i < points_.size(); ++i) {
    ScenePoint& point = points_[i];
    if (!point.seen) continue;
    --histories_[i].age;
    point.sigma_px = sigma_of(histories_[i]);
    if (const auto r = point_residual(point, point.inverse_depth, lens, T_camera_world))
      point.seen_px += kSettle * r->px;
  }
}

void PointTracks::learn(std::span<const double> inverse_depths, const Intrinsics& lens,
                        const RigidTransform& T_camera_world) {
  for (std::size_t i = points_.size(); i-- > 0;) {
    ScenePoint& point = points_[i];
    if (!point.seen) continue;
    const auto r = point_residual(point, inverse_depths[i], lens, T_camera_world);
    if (!r || !(r->squared_sigmas < kInlierSigmas * kInlierSigmas)) {
      if (++histories_[i].outlier >= options_.outlier_patience) remove(i);
      continue;
    }
    histories_[i].outlier = 0;
    point.inverse_depth = inverse_depths[i];
    point.seen_px += options_.pull * r->px;
    const double gained = r->per_inverse_depth.squaredNorm() / (point.sigma_px * point.sigma_px);
    const double most =
        1 / std::pow(kBestRelative * std::max(point.inverse_depth, kLeastInverse * kTypicalInverseDepth), 2);
    point.information =
        std::min(kForget * point.information + gained, std::max(most, histories_[i].seed_information));
  }
}

double PointTracks::sigma_of(const History& history) const {
  return noise_px_ * std::sqrt(1 + options_.sigma_growth * history.age);
}

void PointTracks::inverse_depths(std::vector<double>& depths) const {
  depths.resize(points_.size());
  std::transform(points_.begin(), points_.end(), depths.begin(),
                 [](const auto& p) { return p.inverse_depth; });
}

void PointTracks::learn_noise(double scale, double rate) {
  const double measured = std::clamp(scale * noise_px_, options_.least_sigma_px, options_.most_sigma_px);
  noise_px_ += rate * (measured - noise_px_);
  for (std::size_t i = 0; i < points_.size(); ++i) points_[i].sigma_px = sigma_of(histories_[i]);
}

void PointTracks::restart_when_thin() {
  if (2 * static_cast<int>(points_.size()) >= options_.points) return;
  points_.clear();
  histories_.clear();
}

void PointTracks::coast(const CameraView& view) {
  for (std::size_t i = points_.size(); i-- > 0;) {
    ScenePoint& point = points_[i];
    const auto r = point_residual(point, point.inverse_depth, view.lens, view.T_camera_world);
    histories_[i].unseen = point.seen ? 0 : histories_[i].unseen + 1;
    if (!point.seen && r) point.seen_px += r->px;
    const bool keep = r && histories_[i].unseen <= options_.longest_coast &&
                      histories_[i].age < options_.longest_track &&
                      is_inside(point.seen_px, view.rows, view.cols);
    if (!keep) remove(i);
  }
}

void PointTracks::mark_all_unseen() {
  for (ScenePoint& point : points_) point.seen = false;
}

double PointTracks::expected_inverse_depth(const Eigen::Vector2d& px, double reach_px,
                                           const RigidTransform& T_camera_world) const {
  double sum = kTypicalWeight * kTypicalInverseDepth, weights = kTypicalWeight;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const double distance = (points_[i].seen_px - px).squaredNorm() / (reach_px * reach_px);
    if (distance > kReach2 || histories_[i].age == 0 || histories_[i].outlier > 0) continue;
    const double learnt =
        1 - histories_[i].seed_information / std::max(points_[i].information, histories_[i].seed_information);
    const double weight = std::exp(-0.5 * distance) * learnt;
    const Eigen::Vector3d y =
        T_camera_world.R * points_[i].direction_world +
        points_[i].inverse_depth * (T_camera_world.R * points_[i].origin_world + T_camera_world.t);
    sum += weight * points_[i].inverse_depth / std::max(y.z(), kNearestZ), weights += weight;
  }
  return sum / weights;
}

void PointTracks::seed(const Image<float>& confidence, const CameraView& view, Depths depths) {
  if (depths == Depths::Unknown && !points_.empty()) return;
  const auto& [rows, cols, lens, T_camera_world] = view;
  const double cell = std::sqrt(static_cast<double>(rows) * cols / options_.points);
  const int across = std::max(1, static_cast<int>(cols / cell)),
            down = std::max(1, static_cast<int>(rows / cell));
  const double cell_x = static_cast<double>(cols) / across, cell_y = static_cast<double>(rows) / down;
  occupied_.assign(static_cast<std::size_t>(across) * static_cast<std::size_t>(down), 0);
  const auto cell_of = [&](const Eigen::Vector2d& px) {
    const int x = std::clamp(static_cast<int>(px.x() / cell_x), 0, across - 1);
    const int y = std::clamp(static_cast<int>(px.y() / cell_y), 0, down - 1);
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(across) + static_cast<std::size_t>(x);
  };
  const auto is_sure = [&](const Eigen::Vector2d& px) {
    return confidence.empty() ||
           confidence.at(0, static_cast<int>(px.y()), static_cast<int>(px.x())) >= options_.least_confidence;
  };
  for (const ScenePoint& point : points_) occupied_[cell_of(point.seen_px)] = 1;

  const RigidTransform T_world_camera = T_camera_world.inverse();
  ++frame_;
  for (int y = 0; y < down; ++y)
    for (int x = 0; x < across; ++x) {
      const unsigned index = static_cast<unsigned>(y * across + x);
      if (occupied_[index]) continue;
      const Eigen::Vector2d px((x + kCellMargin + kJittered * jitter(index, frame_, 1)) * cell_x,
                               (y + kCellMargin + kJittered * jitter(index, frame_, 2)) * cell_y);
      if (!is_inside(px, rows, cols) || !is_sure(px)) continue;
      ScenePoint point;
      point.origin_world = T_world_camera.t;
      point.direction_world = T_world_camera.R * ray(lens, px);
      point.inverse_depth = expected_inverse_depth(px, 2 * cell, T_camera_world);
      const double spread = (depths == Depths::Known ? options_.prior_spread : options_.vague_spread) *
                            std::max(point.inverse_depth, kLeastOfNew * kTypicalInverseDepth);
      point.information = 1 / (spread * spread);
      point.seen_px = px;
      points_.push_back(point);
      histories_.push_back({.seed_information = point.information, .first_px = px});
    }
}

}  // namespace hdrcam
