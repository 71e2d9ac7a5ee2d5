#include "online/exposure/scene_pixels.h"

#include <algorithm>
#include <cmath>

#include "online/pictures/between_pixels.h"

namespace hdrcam {
namespace {

constexpr int kColumns = 16, kRows = 12;  // cells of the picture, one pixel each
static_assert(kColumns * kRows * ScenePixels::kFrames == ScenePixels::kPixels);

// Places along the sides of a cell are those of the R2 sequence (M. Roberts 2018): 1/g and 1/g^2 with
// g^3 = g + 1. kInverseGolden is the same along one line: 1/g with g^2 = g + 1.
constexpr double kInversePlastic = 0.7548776662, kInversePlastic2 = 0.5698402910;
constexpr double kInverseGolden = 0.6180339887;

// Of misalignment^2: about what Fusion::warp_variance adds, in the mean over fractions of a pixel, where the
// motion is along one axis, .53 (.3 + .7 / 3). Where it is along both, it adds .77 (.3 + .7 * 2 / 3).
constexpr float kMisaligned = 0.5f;

// The fractional part of n times an irrational number: evenly spread, without a period.
float spread(std::uint64_t n, double step) {
  const double v = static_cast<double>(n) * step;
  return static_cast<float>(v - std::floor(v));
}

// A pixel of the state, in one channel.
struct StatePixel {
  const RadianceEstimate& state;
  int channel, y, x;

  float radiance() const { return state.radiance.at(channel, y, x); }
  float variance() const { return state.variance.at(channel, y, x); }
  float radiance_at(Offset by) const {
    return BetweenPixels(state.radiance.rows(), state.radiance.cols(), x, y, by).of(state.radiance, channel);
  }
};

float contrast_3x3(const StatePixel& pixel) {
  float sum = 0, squares = 0;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      const float v = pixel.state.radiance.at(pixel.channel, pixel.y + dy, pixel.x + dx);
      sum += v, squares += v * v;
    }
  return std::max(0.f, squares / 9 - sum / 9 * (sum / 9));
}

// How far the scene moves to the next frame, for each pixel that it moved from the one before: the middles of
// exposures are not evenly spaced. Far motion counts as much as near motion.
float pace_of(const Image<float>& to_previous, const Image<float>& to_next) {
  constexpr float kStill = 1e-3f, kLeast = 0.25f, kMost = 4;
  const int rows = to_next.rows(), cols = to_next.cols();
  float along = kStill, squares = kStill;
  for (int j = 0; j < kRows; ++j)
    for (int i = 0; i < kColumns; ++i) {
      const int y = (2 * j + 1) * rows / (2 * kRows), x = (2 * i + 1) * cols / (2 * kColumns);
      const Offset back = offset_at(to_previous, x, y), on = offset_at(to_next, x, y);
      const float squared = back.x * back.x + back.y * back.y, weight = 1 / (1 + squared);
      along -= weight * (on.x * back.x + on.y * back.y), squares += weight * squared;
    }
  return std::clamp(along / squares, kLeast, kMost);
}

// What is wrong in the radiance of a pixel, squared, that was moved by one of two motions where the other is
// right; so much is `change` their difference.
float slip(const StatePixel& pixel, Offset change) {
  const auto moved = [&](float by) { return pixel.radiance_at(by * change) - pixel.radiance(); };
  const float on = moved(1), back = moved(-1);
  const float noise = std::min(1.f, length_of(change)) * pixel.variance();
  return std::max(0.f, (on * on + back * back) / 4 - noise);  // each motion has half of the change
}

// What the radiance of a pixel changes by if it is exposed for this fraction of its motion to the frame
// before, squared. Means over several pixels have less of its variance.
float squared_blur_of(const StatePixel& pixel, Offset motion, float fraction) {
  constexpr int kLeastTaps = 3, kMostTaps = 9;
  const float span = std::sqrt(motion.x * motion.x + motion.y * motion.y) * fraction;
  const int taps = std::clamp(static_cast<int>(std::ceil(span)) + 1, kLeastTaps, kMostTaps);
  float sum = 0;
  for (int t = 0; t < taps; ++t) {
    const float instant = fraction * ((static_cast<float>(t) + 0.5f) / static_cast<float>(taps) - 0.5f);
    sum += pixel.radiance_at(instant * motion);
  }
  const float blur = sum / static_cast<float>(taps) - pixel.radiance();
  return std::max(0.f, blur * blur - std::min(1.f, span) * pixel.variance());
}

}  // namespace

ScenePixels::ScenePixels(const FusionOptions& fusion)
    : misaligned_(kMisaligned * fusion.misalignment * fusion.misalignment) {}

void ScenePixels::see(const FrameEstimate& estimate) {
  const ExposedFrame& frame = estimate.frame;
  const int rows = frame.codes.rows(), cols = frame.codes.cols();
  constexpr int kLeastSize = 8;  // pixels
  if (estimate.to_previous == nullptr || rows < kLeastSize || cols < kLeastSize) return;
  if (!(frame.interval_s > 0)) return;
  interval_s_ = frame.interval_s;
  const float pace =
      estimate.to_next != nullptr ? pace_of(estimate.to_previous->vectors, *estimate.to_next) : 1;
  const float down = spread(frames_, kInversePlastic), across = spread(frames_, kInversePlastic2);
  const auto first = static_cast<std::size_t>(frames_ % kFrames) * kColumns * kRows;
  for (int j = 0; j < kRows; ++j)
    for (int i = 0; i < kColumns; ++i) {
      const auto y = static_cast<int>((static_cast<float>(j) + down) * static_cast<float>(rows - 2) / kRows);
      const auto x =
          static_cast<int>((static_cast<float>(i) + across) * static_cast<float>(cols - 2) / kColumns);
      take(estimate, pace, y + 1, x + 1, first + static_cast<std::size_t>(j * kColumns + i));
    }
  ++frames_;
}

void ScenePixels::take(const FrameEstimate& estimate, float pace, int y, int x, std::size_t to) {
  constexpr float kUnknownStops = 2;  // above its bound a clipped pixel may be as much brighter
  // Slips count so much: motion that is wrong alike in both steps does not change, and its surroundings slip
  // with it. With this weight cycles differ in the forecast as their pictures do (docs/decisions/camera.md).
  constexpr float kSlips = 32;
  const StatePixel pixel{estimate.state, channel(static_cast<int>(to)), y, x};
  const float here = pixel.radiance(), variance = pixel.variance();
  const Offset motion = offset_at(estimate.to_previous->vectors, x, y);
  const float length = std::sqrt(motion.x * motion.x + motion.y * motion.y);
  const bool known = variance <= estimate.unseen_variance;
  radiance_[to] =
      known ? here : here * std::exp2(kUnknownStops * spread(to * kFrames + frames_, kInverseGolden));
  kept_[to] = std::clamp(estimate.to_previous->confidence.at(0, y, x), 0.f, 1.f);
  // what looks like contrast is noise of the state, too
  const float contrast = known ? std::max(0.f, contrast_3x3(pixel) - variance) : 0;
  misalignment_[to] = misaligned_ * std::min(1.f, length) * contrast;
  if (known && estimate.to_next != nullptr) {
    const Offset next = offset_at(*estimate.to_next, x, y);
    const Offset change{next.x + pace * motion.x, next.y + pace * motion.y};
    misalignment_[to] += kSlips * slip(pixel, change);
  }
  for (int k = 0; k < kLengths; ++k)
    squared_blur_[static_cast<std::size_t>(k)][to] =
        known ? squared_blur_of(pixel, motion, std::ldexp(1.f, -k)) : 0;
}

}  // namespace hdrcam
