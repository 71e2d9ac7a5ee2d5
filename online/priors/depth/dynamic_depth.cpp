#include "online/priors/depth/dynamic_depth.h"

#include <algorithm>
#include <cmath>

#include "hal/core/median.h"

namespace hdrcam {
namespace {

constexpr int kRadius = 2;                 // of the vote on whether a point moves
constexpr int kNear = 3, kFar = 8;         // from a region: what is around it, past the edge that flow smears
constexpr std::size_t kFewestAround = 10;  // points
constexpr int kBelow = 4;                  // rows under a region that count as what it stands on
constexpr std::int32_t kStatic = 0, kUnlabelled = -1;

}  // namespace

DynamicDepth::DynamicDepth(const DepthOptions& depth, const DynamicDepthOptions& options,
                           const Intrinsics& lens, int rows, int cols, WorkerPool& pool)
    : options_(options), measured_(depth, lens, rows, cols, pool) {
  const std::size_t points = measured_.dynamic().size();
  waiting_.reserve(points);
  values_.reserve(points);
  regions_.reserve(points / static_cast<std::size_t>(options.least_points) + 1);
}

const DepthMap& DynamicDepth::estimate(const SeenFrame& seen, const CameraPose& pose) {
  const DepthMap& measured = measured_.estimate(seen, pose);
  return complete(measured, measured_.dynamic(), seen.motion.to_previous);
}

const DepthMap& DynamicDepth::complete(const DepthMap& measured, const Image<float>& dynamic,
                                       const FlowField& to_previous) {
  completed_.copy_from(measured);
  if (!guess_.same_shape(measured.weight)) {
    guess_.reshape_like(measured.weight);
    guess_.fill(0);
  }
  if (!(options_.nearer > 0)) return completed_;
  mark_moving(measured, dynamic);
  find_regions();
  measure_reach();
  for (int label = 1; label <= static_cast<int>(regions_.size()); ++label) {
    Region& region = regions_[static_cast<std::size_t>(label - 1)];
    const float behind = around(label, measured), ground = below(label, measured);
    if (!(behind > 0)) continue;
    const float guess = ground > options_.standing * behind ? ground : options_.nearer * behind;
    const float last = last_guess(label, to_previous);
    region.inverse_depth = last > 0 ? guess * std::pow(last / guess, options_.keep) : guess;
  }
  for (std::size_t i = 0; i < guess_.size(); ++i) {
    const std::int32_t label = label_.samples()[i];
    const float guess = label > 0 ? regions_[static_cast<std::size_t>(label - 1)].inverse_depth : 0;
    guess_.samples()[i] = guess;
    if (!(guess > 0)) continue;
    completed_.inverse_depth.samples()[i] = guess;
    completed_.weight.samples()[i] = options_.weight;
  }
  return completed_;
}

// A point moves if more of its neighbours do than are measured as static.
void DynamicDepth::mark_moving(const DepthMap& measured, const Image<float>& dynamic) {
  const int rows = dynamic.rows(), cols = dynamic.cols();
  nearest_.reshape(1, rows, cols);
  label_.reshape(1, rows, cols);
  for (int y = 0; y < rows; ++y) {  // sums along rows
    const auto vote = [&](int x) {
      return x < 0 || x >= cols
                 ? 0
                 : (dynamic.at(0, y, x) > 0) - (measured.weight.at(0, y, x) >= DepthMap::kBelieved);
    };
    int sum = 0;
    for (int x = 0; x < kRadius; ++x) sum += vote(x);
    for (int x = 0; x < cols; ++x) {
      sum += vote(x + kRadius) - vote(x - kRadius - 1);
      nearest_.at(0, y, x) = sum;
    }
  }
  for (int y = 0; y < rows; ++y) {
    const int first = std::max(0, y - kRadius), last = std::min(rows - 1, y + kRadius);
    for (int x = 0; x < cols; ++x) {
      int votes = 0;
      for (int v = first; v <= last; ++v) votes += nearest_.at(0, v, x);
      label_.at(0, y, x) = votes > 0 ? kUnlabelled : kStatic;
    }
  }
}

void DynamicDepth::find_regions() {
  regions_.clear();
  for (int y = 0; y < label_.rows(); ++y)
    for (int x = 0; x < label_.cols(); ++x)
      if (label_.at(0, y, x) == kUnlabelled) {
        regions_.push_back({.points = 0, .top = y, .bottom = y, .inverse_depth = 0});
        grow(y, x, static_cast<int>(regions_.size()));
      }
}

void DynamicDepth::grow(int y, int x, int label) {
  const int cols = label_.cols();
  Region& region = regions_.back();
  const auto take = [&](int v, int u) {
    if (v < 0 || v >= label_.rows() || u < 0 || u >= cols || label_.at(0, v, u) != kUnlabelled) return;
    label_.at(0, v, u) = label;
    waiting_.push_back(v * cols + u);
  };
  waiting_.clear();
  take(y, x);
  for (std::size_t next = 0; next < waiting_.size(); ++next) {
    const int v = waiting_[next] / cols, u = waiting_[next] % cols;
    ++region.points;
    region.bottom = std::max(region.bottom, v);
    take(v - 1, u), take(v + 1, u), take(v, u - 1), take(v, u + 1);
  }
  if (region.points >= options_.least_points) return;
  for (const std::int32_t at : waiting_) label_.samples()[static_cast<std::size_t>(at)] = kStatic;
  regions_.pop_back();
}

// The nearest region of each point, and how far it is (city blocks), in two passes.
void DynamicDepth::measure_reach() {
  const int rows = label_.rows(), cols = label_.cols();
  nearest_.copy_from(label_);
  reach_.reshape_like(label_);
  for (std::size_t i = 0; i < label_.size(); ++i)
    reach_.samples()[i] = label_.samples()[i] > 0 ? 0 : rows + cols;
  const auto follow = [&](int y, int x, int v, int u) {
    if (v < 0 || v >= rows || u < 0 || u >= cols || reach_.at(0, v, u) + 1 >= reach_.at(0, y, x)) return;
    reach_.at(0, y, x) = reach_.at(0, v, u) + 1;
    nearest_.at(0, y, x) = nearest_.at(0, v, u);
  };
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < cols; ++x) follow(y, x, y - 1, x), follow(y, x, y, x - 1);
  for (int y = rows - 1; y >= 0; --y)
    for (int x = cols - 1; x >= 0; --x) follow(y, x, y + 1, x), follow(y, x, y, x + 1);
}

// Median inverse depth of what is around a region; 0 where too little of it is measured.
float DynamicDepth::around(int label, const DepthMap& measured) {
  const Region& region = regions_[static_cast<std::size_t>(label - 1)];
  values_.clear();
  for (int y = std::max(0, region.top - kFar); y <= std::min(label_.rows() - 1, region.bottom + kFar); ++y)
    for (int x = 0; x < label_.cols(); ++x)
      if (nearest_.at(0, y, x) == label && reach_.at(0, y, x) >= kNear && reach_.at(0, y, x) <= kFar &&
          measured.weight.at(0, y, x) >= DepthMap::kBelieved)
        values_.push_back(measured.inverse_depth.at(0, y, x));
  return values_.size() < kFewestAround ? 0 : median(values_);
}

// Median inverse depth of what is below a region's lowest row; 0 where too little of it is measured.
float DynamicDepth::below(int label, const DepthMap& measured) {
  const int first = regions_[static_cast<std::size_t>(label - 1)].bottom + kNear;
  values_.clear();
  for (int y = first; y < std::min(first + kBelow, label_.rows()); ++y)
    for (int x = 0; x < label_.cols(); ++x)
      if (nearest_.at(0, y, x) == label && reach_.at(0, y, x) <= kFar &&
          measured.weight.at(0, y, x) >= DepthMap::kBelieved)
        values_.push_back(measured.inverse_depth.at(0, y, x));
  return values_.size() < kFewestAround ? 0 : median(values_);
}

// What the region was guessed at in the last frame: the median along the flow; 0 if it is new.
float DynamicDepth::last_guess(int label, const FlowField& to_previous) {
  if (to_previous.empty()) return 0;
  const Region& region = regions_[static_cast<std::size_t>(label - 1)];
  values_.clear();
  const int rows = label_.rows(), cols = label_.cols();
  for (int y = region.top; y <= region.bottom; ++y)
    for (int x = 0; x < cols; ++x) {
      if (label_.at(0, y, x) != label) continue;
      const int py = completed_.pixel_of(y, to_previous.vectors.rows());
      const int px = completed_.pixel_of(x, to_previous.vectors.cols());
      const float v = static_cast<float>(py) + to_previous.vectors.at(1, py, px);
      const float u = static_cast<float>(px) + to_previous.vectors.at(0, py, px);
      const float step = static_cast<float>(completed_.step_px);
      if (!(v >= 0 && u >= 0 && v < static_cast<float>(rows) * step && u < static_cast<float>(cols) * step))
        continue;
      const float guess = guess_.at(0, static_cast<int>(v / step), static_cast<int>(u / step));
      if (guess > 0) values_.push_back(guess);
    }
  return median(values_);
}

}  // namespace hdrcam
