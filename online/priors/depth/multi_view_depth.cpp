#include "online/priors/depth/multi_view_depth.h"

#include <algorithm>
#include <cmath>

#include "hal/core/median.h"
#include "online/priors/depth/grid_sample.h"

namespace hdrcam {
namespace {

// Neighbouring grid points, a step apart, are on two surfaces where their places in a keyframe are so many
// steps farther apart; values between them are not interpolated.
constexpr float kContinuous_steps = 1.5f;
constexpr float kContinuousDepth = 0.15f;  // the same for inverse depths, relative
constexpr float kNearestZ = 0.05f;         // of a ray in the other camera: nearer points are not visible
constexpr float kDisagreement = 9;         // squared sigmas between the learnt and the measured depth
constexpr float kNoBaseline2 = 1e-12f;     // squared shift per inverse depth that only rounding makes
constexpr float kNoTranslation = 1e-6f;    // units of length of the poses: only rounding makes it
constexpr float kLeastInverse = 1e-6f;     // keeps the uncertainty of the farthest points above 0

// How many times less two estimates that differ so much count, by their information: Cauchy's weight.
float doubt_of(float difference, float measured, float learnt) {
  return 1 + difference * difference / (kDisagreement * (1 / measured + 1 / learnt));
}

}  // namespace

// Y = R ray + d t: a pixel of this view with inverse depth d, in the other view.
struct MultiViewDepth::Relative {
  float R[3][3], t[3];

  // T_other_this
  explicit Relative(const RigidTransform& T) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) R[i][j] = static_cast<float>(T.R(i, j));
      t[i] = static_cast<float>(T.t(i));
    }
  }
  bool moves() const { return std::max({std::abs(t[0]), std::abs(t[1]), std::abs(t[2])}) > kNoTranslation; }
  void turn(float x, float y, float out[3]) const {
    for (int i = 0; i < 3; ++i) out[i] = R[i][0] * x + R[i][1] * y + R[i][2];
  }
};

MultiViewDepth::MultiViewDepth(const DepthOptions& options, const Intrinsics& lens, int rows, int cols,
                               WorkerPool& pool)
    : options_(options),
      lens_(lens),
      rows_(std::max(2, rows / options.step_px)),
      cols_(std::max(2, cols / options.step_px)),
      pool_(pool) {
  // the lens in steps: grid point x is the centre of pixel x * step + step / 2, and lies at x + 0.5
  const int half_step = options.step_px / 2;
  const double step = options.step_px, first = half_step + 0.5;
  lens_.fx_px /= step, lens_.fy_px /= step;
  lens_.cx_px = (lens_.cx_px - first) / step + 0.5, lens_.cy_px = (lens_.cy_px - first) / step + 0.5;
  for (Keyframe& keyframe : keyframes_) keyframe.seen = Image<float>(3, rows_, cols_);
  learnt_ = Image<float>(2, rows_, cols_);
  prior_.inverse_depth = Image<float>(1, rows_, cols_);
  prior_.weight = Image<float>(1, rows_, cols_);
  prior_.step_px = options.step_px;
  dynamic_ = Image<float>(1, rows_, cols_);
}

const DepthMap& MultiViewDepth::next(const CameraPose& pose, const FlowField& to_previous) {
  const RigidTransform T_world_camera = pose.T_world_camera;
  if (!started_ || to_previous.empty() || pose.lost) {
    restart(T_world_camera);
    return prior_;
  }
  carry(to_previous, Relative(T_world_camera.inverse() * T_world_camera_));
  T_world_camera_ = T_world_camera;
  for (Keyframe& keyframe : keyframes_) ++keyframe.age;
  fuse();

  Keyframe& young = keyframes_[1];
  if (median_parallax(young) > options_.keyframe_parallax_px || young.age >= options_.keyframe_frames) {
    retire(keyframes_[0]);
    std::swap(keyframes_[0], keyframes_[1]);
    begin(keyframes_[1], T_world_camera);
  }
  return prior_;
}

void MultiViewDepth::restart(const RigidTransform& T_world_camera) {
  started_ = true;
  T_world_camera_ = T_world_camera;
  for (Keyframe& keyframe : keyframes_) begin(keyframe, T_world_camera);
  learnt_.fill(0);
  prior_.inverse_depth.fill(0);
  prior_.weight.fill(0);
  dynamic_.fill(0);
}

void MultiViewDepth::begin(Keyframe& keyframe, const RigidTransform& T_world_camera) {
  keyframe.T_world_camera = T_world_camera;
  keyframe.age = 0;
  for (int y = 0; y < rows_; ++y)
    for (int x = 0; x < cols_; ++x) {
      keyframe.seen.at(0, y, x) = static_cast<float>(x) + 0.5f;
      keyframe.seen.at(1, y, x) = static_cast<float>(y) + 0.5f;
      keyframe.seen.at(2, y, x) = 1;
    }
}

// Carries all stored positions and depths from the previous frame's pixels to this frame's. previous:
// T_camera_previous.
void MultiViewDepth::carry(const FlowField& to_previous, const Relative& previous) {
  const float per_step = 1 / static_cast<float>(options_.step_px);
  const ScratchLease room(pool_.scratch(), rows_, cols_,
                          {{&keyframes_[0].carried, 3}, {&keyframes_[1].carried, 3}, {&carried_learnt_, 2}});
  pool_.for_rows(rows_, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y)
      for (int x = 0; x < cols_; ++x) {
        for (Keyframe& keyframe : keyframes_) keyframe.carried.at(2, y, x) = 0;
        carried_learnt_.at(0, y, x) = carried_learnt_.at(1, y, x) = 0;
        const int px = prior_.pixel_of(x, to_previous.confidence.cols());
        const int py = prior_.pixel_of(y, to_previous.confidence.rows());
        if (!(to_previous.confidence.at(0, py, px) >= options_.least_confidence)) continue;
        const float from_x = static_cast<float>(x) + to_previous.vectors.at(0, py, px) * per_step;
        const float from_y = static_cast<float>(y) + to_previous.vectors.at(1, py, px) * per_step;
        const std::optional<GridPlace> from = locate(from_x, from_y, rows_, cols_);
        if (!from) continue;
        for (Keyframe& keyframe : keyframes_) carry_position(keyframe, *from, y, x);
        carry_depth(previous, *from, y, x);
      }
  });
  for (Keyframe& keyframe : keyframes_) keyframe.seen.copy_from(keyframe.carried);
  learnt_.copy_from(carried_learnt_);
}

// Where the point was in the keyframe: interpolated on one surface, taken from the nearest neighbour across
// an edge.
void MultiViewDepth::carry_position(Keyframe& keyframe, const GridPlace& from, int y, int x) {
  const int near_x = from.nearest_x(), near_y = from.nearest_y();
  if (!(keyframe.seen.at(2, near_y, near_x) > 0)) return;
  const Corners u = corners(keyframe.seen, 0, from), v = corners(keyframe.seen, 1, from);
  const bool all_known = corners(keyframe.seen, 2, from).least() > 0;
  const bool one_surface =
      all_known && u.spread() < 1 + kContinuous_steps && v.spread() < 1 + kContinuous_steps;
  keyframe.carried.at(0, y, x) =
      one_surface ? u.mix(from) : keyframe.seen.at(0, near_y, near_x) + from.x() - static_cast<float>(near_x);
  keyframe.carried.at(1, y, x) =
      one_surface ? v.mix(from) : keyframe.seen.at(1, near_y, near_x) + from.y() - static_cast<float>(near_y);
  keyframe.carried.at(2, y, x) = 1;
}

// The learnt depth of the point, as inverse depth in this camera.
void MultiViewDepth::carry_depth(const Relative& previous, const GridPlace& from, int y, int x) {
  const Corners depth = corners(learnt_, 0, from), information = corners(learnt_, 1, from);
  const bool smooth = information.least() > 0 && depth.spread() < kContinuousDepth * depth.mix(from);
  const float d = smooth ? depth.mix(from) : learnt_.at(0, from.nearest_y(), from.nearest_x());
  const float known = smooth ? information.mix(from) : learnt_.at(1, from.nearest_y(), from.nearest_x());
  if (!(known > 0)) return;
  float ray[3];
  previous.turn((from.x() + 0.5f - static_cast<float>(lens_.cx_px)) / static_cast<float>(lens_.fx_px),
                (from.y() + 0.5f - static_cast<float>(lens_.cy_px)) / static_cast<float>(lens_.fy_px), ray);
  const float z = ray[2] + d * previous.t[2];
  if (!(z > kNearestZ && ray[2] > kNearestZ)) return;
  const float per_depth = z * z / ray[2];  // change of d for one of d / z
  // what the camera learnt outlasts any time that it stands still, or only turns
  const float forget = previous.moves() ? options_.forget : 0;
  const float keep = 1 / ((1 + forget) * (1 + forget));
  carried_learnt_.at(0, y, x) = d / z;
  carried_learnt_.at(1, y, x) = known * per_depth * per_depth * keep;
}

// Of a displacement to a keyframe: the noise of its first flow, and of each further one in the chain.
float MultiViewDepth::sigma_px(const Keyframe& keyframe) const {
  const float grown = static_cast<float>(keyframe.age) * options_.noise_growth_px * options_.noise_growth_px;
  return std::sqrt(options_.noise_px * options_.noise_px + grown);
}

// The inverse depth of a static point from the displacement to a keyframe.
MultiViewDepth::Measured MultiViewDepth::measure(const Keyframe& keyframe, const Relative& relative, int y,
                                                 int x) const {
  if (!(keyframe.seen.at(2, y, x) > 0)) return {};
  const auto fx = static_cast<float>(lens_.fx_px), fy = static_cast<float>(lens_.fy_px);
  const auto cx = static_cast<float>(lens_.cx_px), cy = static_cast<float>(lens_.cy_px);
  const float u = (keyframe.seen.at(0, y, x) - cx) / fx, v = (keyframe.seen.at(1, y, x) - cy) / fy;
  float a[3];
  relative.turn((static_cast<float>(x) + 0.5f - cx) / fx, (static_cast<float>(y) + 0.5f - cy) / fy, a);
  // a + d t projects to (u, v): (ax, ay) + d (bx, by) = 0
  const float ax = a[0] - u * a[2], ay = a[1] - v * a[2];
  const float bx = relative.t[0] - u * relative.t[2], by = relative.t[1] - v * relative.t[2];
  const float bb = bx * bx + by * by;
  const float sigma = sigma_px(keyframe) / (fx * static_cast<float>(options_.step_px));
  if (!(bb > kNoBaseline2)) return {};
  const float d = -(ax * bx + ay * by) / bb;
  const float z = a[2] + std::max(d, 0.f) * relative.t[2];
  if (!(z > kNearestZ)) return {};
  const float sigma_d = sigma * z / std::sqrt(bb);
  const float across = (ax * by - ay * bx) / (std::sqrt(bb) * z);
  if (std::abs(across) > options_.epipolar_sigmas * sigma || d < -options_.epipolar_sigmas * sigma_d)
    return {.point = Seen::Dynamic};
  return {Seen::Static, std::max(d, 0.f), 1 / (sigma_d * sigma_d)};
}

// This frame's prior: the learnt depth fused with the measurements of both keyframes.
void MultiViewDepth::fuse() {
  const std::array<Relative, 2> relative{Relative(keyframes_[0].T_world_camera.inverse() * T_world_camera_),
                                         Relative(keyframes_[1].T_world_camera.inverse() * T_world_camera_)};
  pool_.for_rows(rows_, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y)
      for (int x = 0; x < cols_; ++x) {
        float sum = 0, information = 0;
        int against = 0;  // keyframes that see it move
        for (std::size_t k = 0; k < 2; ++k) {
          const Measured seen = measure(keyframes_[k], relative[k], y, x);
          against += seen.point == Seen::Dynamic;
          if (seen.point != Seen::Static) continue;
          sum += seen.inverse_depth * seen.information, information += seen.information;
        }
        // what both see move is not where its depth was learnt
        const float learnt = learnt_.at(0, y, x), known = against < 2 ? learnt_.at(1, y, x) : 0;
        if (known > 0) {
          float trust = 1;
          if (information > 0) {
            const float difference = sum / information - learnt;
            trust = 1 / doubt_of(difference, information, known);
          }
          sum += learnt * known * trust, information += known * trust;
        }
        dynamic_.at(0, y, x) = against > 0 && !(information > 0) ? 1.f : 0.f;
        const float d = information > 0 ? sum / information : 0;
        const float best = options_.best_relative * d;
        const float squared = d * d;
        prior_.inverse_depth.at(0, y, x) = d;
        prior_.weight.at(0, y, x) =
            squared > 0 ? squared / (squared + std::max(1 / information, best * best)) : 0;
      }
  });
}

// Drops a keyframe: its measurement is fused into the learnt depth.
void MultiViewDepth::retire(const Keyframe& keyframe) {
  const Relative relative(keyframe.T_world_camera.inverse() * T_world_camera_);
  pool_.for_rows(rows_, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y)
      for (int x = 0; x < cols_; ++x) {
        const Measured seen = measure(keyframe, relative, y, x);
        if (seen.point != Seen::Static) continue;
        float &learnt = learnt_.at(0, y, x), &known = learnt_.at(1, y, x);
        if (known > 0) known /= doubt_of(seen.inverse_depth - learnt, seen.information, known);
        learnt = (learnt * known + seen.inverse_depth * seen.information) / (known + seen.information);
        const float best = options_.best_relative * std::max(learnt, kLeastInverse);
        known = std::min(known + seen.information, 1 / (best * best));
      }
  });
}

// How far the translation since the keyframe has moved the known points, px of the full picture.
float MultiViewDepth::median_parallax(const Keyframe& keyframe) {
  constexpr int kEvery = 8;
  const Relative relative(keyframe.T_world_camera.inverse() * T_world_camera_);
  parallaxes_.clear();
  for (int y = kEvery / 2; y < rows_; y += kEvery)
    for (int x = kEvery / 2; x < cols_; x += kEvery) {
      const Measured seen = measure(keyframe, relative, y, x);
      if (seen.point != Seen::Static) continue;
      parallaxes_.push_back(seen.inverse_depth * std::sqrt(seen.information) * sigma_px(keyframe));
    }
  return median(parallaxes_);
}

}  // namespace hdrcam
