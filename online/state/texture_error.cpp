#include "online/state/texture_error.h"

#include <algorithm>
#include <cmath>

#include "capture/clip_policy.h"

namespace hdrcam {
namespace {

constexpr int kMargin = 2, kStride = 3;  // pixels
constexpr float kMinConfidence = 0.8f;   // of the flow
constexpr float kMaxBlur = 1;            // pixels: a longer way during the exposure changes textures itself
constexpr float kMinContrast = 10;       // over the variance of noise
constexpr std::size_t kEnough = 300;     // comparisons
constexpr float kLearning = 0.2f;        // share of a new frame

// Catmull-Rom between the second and the third of four, as the state itself is carried.
float between(const float* v, float t) {
  return v[1] + 0.5f * t *
                    (v[2] - v[0] +
                     t * (2 * v[0] - 5 * v[1] + 4 * v[2] - v[3] + t * (3 * (v[1] - v[2]) + v[3] - v[0])));
}

}  // namespace

void TextureError::observe(const ExposedFrame& frame, const RadianceState& state,
                           const FlowField& to_previous, const ExposureTables& tables, float white) {
  shares_.clear();
  if (to_previous.vectors.empty()) return;
  shares_.reserve(frame.codes.size() / (kStride * kStride) + frame.codes.size() / kStride);  // once
  const float known = known_limit(white);
  for (int y = kMargin; y < frame.codes.rows() - kMargin; y += kStride)
    for (int x = kMargin; x < frame.codes.cols() - kMargin; x += kStride)
      if (to_previous.confidence.at(0, y, x) >= kMinConfidence)
        for (int c = 0; c < 3; ++c) compare(c, y, x, frame, state, to_previous, tables, known);
  if (shares_.size() < kEnough) return;
  const auto middle = shares_.begin() + static_cast<std::ptrdiff_t>(shares_.size() / 2);
  std::nth_element(shares_.begin(), middle, shares_.end());
  disagreement_ += kLearning * (*middle - disagreement_);
}

void TextureError::compare(int channel, int y, int x, const ExposedFrame& frame, const RadianceState& state,
                           const FlowField& to_previous, const ExposureTables& tables, float known) {
  using namespace clip_policy;
  const float code = frame.codes.at(channel, y, x);
  if (code < kCompareDarkEnd || code > kCompareFadeBegin) return;
  const float dx = to_previous.vectors.at(0, y, x), dy = to_previous.vectors.at(1, y, x);
  if (std::hypot(dx, dy) * frame.blur_fraction > kMaxBlur) return;
  const float from_x = static_cast<float>(x) + dx, from_y = static_cast<float>(y) + dy;
  const Image<float>& light = state.radiance;
  if (!(from_x >= 1 && from_y >= 1 && from_x < static_cast<float>(light.cols() - 3) &&
        from_y < static_cast<float>(light.rows() - 3)))
    return;
  const int left = static_cast<int>(from_x), top = static_cast<int>(from_y);
  const float across = from_x - static_cast<float>(left), down = from_y - static_cast<float>(top);

  float carried[4], sum = 0, squares = 0;
  for (int j = 0; j < 4; ++j) {
    const float* row = light.row(channel, top - 1 + j) + left - 1;
    const float* variance = state.variance.row(channel, top - 1 + j) + left - 1;
    for (int i = 0; i < 4; ++i) {
      if (variance[i] >= known) return;
      sum += row[i], squares += row[i] * row[i];
    }
    carried[j] = between(row, across);
  }
  const float expected = between(carried, down), mean = sum / 16;
  const float contrast = squares / 16 - mean * mean;
  if (contrast < kMinContrast * tables.variance(channel, mean)) return;
  const float off = tables.radiance(channel, code) - expected;
  shares_.push_back(off * off / contrast);
}

float TextureError::share() const {
  // What the motion's errors leave of sharp pictures, and how more than that is believed. A share of more
  // than kMost is a failure of the motion or of the response, not of pixels.
  constexpr float kOfMatches = 0.06f, kSlope = 3, kMost = 0.12f;
  return std::clamp(kSlope * (disagreement_ - kOfMatches), 0.f, kMost);
}

}  // namespace hdrcam
