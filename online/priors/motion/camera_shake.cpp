#include "online/priors/motion/camera_shake.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "capture/clip_policy.h"
#include "hal/core/median.h"
#include "online/priors/motion/flow_kernels.h"

namespace hdrcam {
namespace {

constexpr int kLeastSide = 15, kMostSide = 135;  // pixels: the shorter side of the coarsest, the finest level
constexpr int kSquare = 16;  // pixels of the finest level: the side of the chessboard's squares
constexpr std::size_t kSmallPicture = 5000;  // pixels
constexpr std::size_t kFewestEdges = 30;     // pixels of a level and half
constexpr float kHardlyMoved = 0.5f;         // pixels: patches find that themselves
constexpr double kAgreed = 0.65;             // of what both say: how far the halves may be apart

void halve(const Image<float>& picture, Image<float>& half) {
  const int rows = picture.rows() / 2, cols = picture.cols() / 2;
  half.reshape(1, rows, cols);
  flow_kernels().halve(picture.plane(0), picture.cols(), rows, cols, half.plane(0), cols);
}

// Between four pixels, all of which are there.
float code_at(const Image<float>& picture, float x, float y) {
  const int left = static_cast<int>(x), top = static_cast<int>(y);
  const float fx = x - static_cast<float>(left), fy = y - static_cast<float>(top);
  const float *a = picture.row(0, top) + left, *b = picture.row(0, top + 1) + left;
  const float above = a[0] + fx * (a[1] - a[0]), below = b[0] + fx * (b[1] - b[0]);
  return above + fy * (below - above);
}

// What Gauss and Newton's step for two unknowns is made of.
struct Normal {
  double xx = 0, xy = 0, yy = 0, x = 0, y = 0;

  void add(double weight, double slope_x, double slope_y, double difference) {
    xx += weight * slope_x * slope_x, xy += weight * slope_x * slope_y, yy += weight * slope_y * slope_y;
    x += weight * slope_x * difference, y += weight * slope_y * difference;
  }
  Offset step() const {
    constexpr double kDamping = 1e-3, kTiny = 1e-6;
    const double damping = kDamping * (xx + yy) + kTiny, a = xx + damping, b = yy + damping;
    const double scale = 1 / (a * b - xy * xy);
    return {static_cast<float>(scale * (b * x - xy * y)), static_cast<float>(scale * (a * y - xy * x))};
  }
  // How far an offset changes what the edges show, squared.
  double squared_change(Offset offset) const {
    const auto u = static_cast<double>(offset.x), v = static_cast<double>(offset.y);
    return xx * u * u + 2 * xy * u * v + yy * v * v;
  }
};

}  // namespace

// What a half of the picture tells.
struct CameraShake::Told {
  Offset moved;
  Normal edges;  // of the last step
};

CameraShake::CameraShake(int rows, int cols) : farthest_px_(static_cast<float>(rows + cols) / 70) {
  for (int scale = 1; std::min(rows, cols) >> scale >= kLeastSide; ++scale) {
    Level& level = levels_.emplace_back();
    level.scale = scale;
    for (Image<float>* picture : {&level.frame, &level.state})
      *picture = Image<float>(1, rows >> scale, cols >> scale);
  }
  for (const Level& level : levels_) {
    if (!level.is_compared()) continue;
    if (square_px_ == 0) square_px_ = kSquare << level.scale;
    const std::size_t most = level.frame.plane_size();
    for (Half& half : halves_)
      half.edges.reserve(most), half.differences.reserve(most), half.sorted.reserve(most);
  }
}

bool CameraShake::Level::is_compared() const { return std::min(frame.rows(), frame.cols()) <= kMostSide; }

Offset CameraShake::measure(const Image<float>& frame, const Image<float>& state,
                            const Image<float>& predicted, float ratio, WorkerPool& pool) {
  if (levels_.empty()) return {};
  shrink(frame, state);
  std::array<std::optional<Told>, 2> told;
  pool.for_each(2, [&](int half) { told[static_cast<std::size_t>(half)] = follow(half, predicted, ratio); });
  const std::optional<Told>& a = told[0];
  const std::optional<Told>& b = told[1];
  if (!a || !b) return {};
  const Offset &p = a->moved, &q = b->moved;
  const Offset both{(p.x + q.x) / 2, (p.y + q.y) / 2}, apart{p.x - q.x, p.y - q.y};
  const auto squared_change = [&](Offset offset) {
    return a->edges.squared_change(offset) + b->edges.squared_change(offset);
  };
  const bool agree = squared_change(apart) < kAgreed * kAgreed * squared_change(both);
  const float far = length_of(both);
  return agree && far > kHardlyMoved && far < farthest_px_ ? both : Offset{};
}

void CameraShake::shrink(const Image<float>& frame, const Image<float>& state) {
  const Image<float>*finer_frame = &frame, *finer_state = &state;
  for (Level& level : levels_) {
    halve(*finer_frame, level.frame), halve(*finer_state, level.state);
    finer_frame = &level.frame, finer_state = &level.state;
  }
}

// What one half of the picture tells, from coarse to fine.
std::optional<CameraShake::Told> CameraShake::follow(int half, const Image<float>& predicted, float ratio) {
  constexpr int kMostSteps = 6;
  Told told;
  for (auto level = levels_.rbegin(); level != levels_.rend() && level->is_compared(); ++level) {
    find_edges(half, *level, predicted, ratio);
    Half& own = halves_[static_cast<std::size_t>(half)];
    for (int step = 0; step < kMostSteps; ++step) {
      const bool goes_on = approach(*level, own, told);
      if (own.differences.size() < kFewestEdges) return std::nullopt;
      if (!goes_on) break;
    }
  }
  return told;
}

// All pixels of a small picture; of a larger one those whose slope is above the mean, which tell most.
void CameraShake::find_edges(int half, const Level& level, const Image<float>& predicted, float ratio) {
  const Image<float>& state = level.state;
  const int rows = state.rows(), cols = state.cols();
  const auto slope_at = [&](int y, int x) {
    return Offset{0.5f * (state.at(0, y, x + 1) - state.at(0, y, x - 1)),
                  0.5f * (state.at(0, y + 1, x) - state.at(0, y - 1, x))};
  };
  double sum = 0;
  for (int y = 1; y < rows - 1; ++y)
    for (int x = 1; x < cols - 1; ++x) {
      const Offset slope = slope_at(y, x);
      sum += static_cast<double>(slope.x * slope.x + slope.y * slope.y);
    }
  const auto mean = static_cast<float>(sum / static_cast<double>(state.plane_size()));
  const float least_slope2 = state.plane_size() > kSmallPicture ? mean : 0;
  const float shrunk = ratio / static_cast<float>(1 << level.scale);
  std::vector<EdgePixel>& edges = halves_[static_cast<std::size_t>(half)].edges;
  edges.clear();
  for (int y = 1; y < rows - 1; ++y)
    for (int x = 1; x < cols - 1; ++x) {
      const int full_x = x << level.scale, full_y = y << level.scale;
      if ((full_x / square_px_ + full_y / square_px_) % 2 != half) continue;
      const float code = state.at(0, y, x);
      const Offset slope = slope_at(y, x);
      if (code > clip_policy::kMotionShare.brightest) continue;
      if (slope.x * slope.x + slope.y * slope.y <= least_slope2) continue;
      const Offset moved = shrunk * offset_at(predicted, full_x, full_y);
      edges.push_back(
          {code, slope.x, slope.y, static_cast<float>(x) - moved.x, static_cast<float>(y) - moved.y});
    }
}

// One step, of at most a pixel of the level; whether the next one may be worth it.
bool CameraShake::approach(const Level& level, Half& half, Told& told) {
  constexpr float kUnseen = std::numeric_limits<float>::infinity();
  constexpr double kLeastSpread2 = 0.05, kCauchy2 = 4;  // codes^2; squared scale of the weights, in sigmas
  constexpr float kArrived = 0.02f;                     // pixels of the level
  const float size = static_cast<float>(1 << level.scale);
  const float u = told.moved.x / size, v = told.moved.y / size;
  const auto right = static_cast<float>(level.frame.cols() - 2),
             bottom = static_cast<float>(level.frame.rows() - 2);
  half.differences.clear(), half.sorted.clear();
  for (const EdgePixel& edge : half.edges) {
    const float x = edge.x - u, y = edge.y - v;
    const bool is_there = x >= 1 && y >= 1 && x < right && y < bottom;
    const float code = is_there ? code_at(level.frame, x, y) : kUnseen;
    const bool counts = code <= clip_policy::kMotionShare.brightest;
    half.differences.push_back(counts ? code - edge.code : kUnseen);
    if (counts) half.sorted.push_back(code - edge.code);
  }
  if (half.sorted.size() < kFewestEdges) return half.differences.clear(), false;
  const float offset = median(half.sorted);
  for (float& difference : half.sorted) difference = std::abs(difference - offset);
  const double sigma = kSigmaPerMad * static_cast<double>(median(half.sorted));
  const double scale2 = std::max(kLeastSpread2, kCauchy2 * sigma * sigma);
  told.edges = {};
  for (std::size_t i = 0; i < half.edges.size(); ++i) {
    if (half.differences[i] == kUnseen) continue;
    const auto difference = static_cast<double>(half.differences[i] - offset);
    told.edges.add(1 / (1 + difference * difference / scale2), static_cast<double>(half.edges[i].slope_x),
                   static_cast<double>(half.edges[i].slope_y), difference);
  }
  const Offset step = told.edges.step();
  const float length = length_of(step), scale = size / std::max(1.f, length);
  told.moved = {told.moved.x + scale * step.x, told.moved.y + scale * step.y};
  return length >= kArrived;
}

}  // namespace hdrcam
