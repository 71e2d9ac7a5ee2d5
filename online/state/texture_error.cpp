#include "online/state/texture_error.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "capture/clip_policy.h"
#include "hal/core/median.h"
#include "online/pictures/sparse_lines.h"

namespace hdrcam {
namespace {

constexpr int kMargin = 2, kStride = 3;  // pixels
constexpr float kMaxBlur = 1;            // pixels: a longer way during the exposure changes textures itself
// Chosen, not measured; share()'s are (docs/decisions/noise.md).
constexpr float kMinContrast = 10;       // over the variance of noise, which then adds at most a tenth
constexpr std::ptrdiff_t kEnough = 300;  // comparisons
constexpr float kLearning = 0.2f;        // share of a new frame

// Catmull-Rom between the second and the third of four, as the state itself is carried.
float between(const float* v, float t) {
  return v[1] + 0.5f * t *
                    (v[2] - v[0] +
                     t * (2 * v[0] - 5 * v[1] + 4 * v[2] - v[3] + t * (3 * (v[1] - v[2]) + v[3] - v[0])));
}

}  // namespace

void TextureError::observe(const StateComparison& seen) {
  if (seen.to_previous.vectors.empty()) return;
  const int rows = seen.frame.codes.rows(), cols = seen.frame.codes.cols();
  const int apart = lines_apart(rows, cols, kStride);
  const int lines = (rows - 2 * kMargin + apart - 1) / apart;
  if (lines <= 0 || cols <= 2 * kMargin) return;
  const auto line_room = 3 * static_cast<std::size_t>((cols - 2 * kMargin + kStride - 1) / kStride);
  shares_.resize(line_room * static_cast<std::size_t>(lines));
  found_.assign(static_cast<std::size_t>(lines), 0);
  pool_.for_each(lines, [&](int i) {
    const auto line = static_cast<std::size_t>(i);
    found_[line] = compare_line(seen, kMargin + i * apart, shares_.data() + line * line_room);
  });
  auto end = shares_.begin() + static_cast<std::ptrdiff_t>(found_[0]);
  for (std::size_t line = 1; line < found_.size(); ++line)
    end = std::copy_n(shares_.begin() + static_cast<std::ptrdiff_t>(line * line_room), found_[line], end);
  const auto count = end - shares_.begin();
  if (count < kEnough) return;
  disagreement_ += kLearning * (median(std::span(shares_.begin(), end)) - disagreement_);
}

// The shares of contrast at the pixels of a line that tell of it, from `shares` on; how many there are.
std::size_t TextureError::compare_line(const StateComparison& seen, int y, float* shares) {
  std::size_t found = 0;
  for (int x = kMargin; x < seen.frame.codes.cols() - kMargin; x += kStride)
    if (seen.to_previous.confidence.at(0, y, x) >= kComparedConfidence)
      for (int c = 0; c < 3; ++c)
        if (const auto share = compare(seen, c, y, x)) shares[found++] = *share;
  return found;
}

// Squared difference between sample and carried state over the local contrast; none where it does not tell.
std::optional<float> TextureError::compare(const StateComparison& seen, int channel, int y, int x) {
  using namespace clip_policy;
  const auto& [frame, state, to_previous, tables, unseen_variance] = seen;
  const float code = frame.codes.at(channel, y, x);
  if (code < kCompareDarkEnd || code > kCompareFadeBegin) return std::nullopt;
  const float dx = to_previous.vectors.at(0, y, x), dy = to_previous.vectors.at(1, y, x);
  if (std::sqrt(dx * dx + dy * dy) * frame.blur_fraction > kMaxBlur) return std::nullopt;
  const float from_x = static_cast<float>(x) + dx, from_y = static_cast<float>(y) + dy;
  const Image<float>& light = state.radiance;
  if (!(from_x >= 1 && from_y >= 1 && from_x < static_cast<float>(light.cols() - 3) &&
        from_y < static_cast<float>(light.rows() - 3)))
    return std::nullopt;
  const int left = static_cast<int>(from_x), top = static_cast<int>(from_y);
  const float across = from_x - static_cast<float>(left), down = from_y - static_cast<float>(top);

  float carried[4], sum = 0, squares = 0;
  for (int j = 0; j < 4; ++j) {
    const float* row = light.row(channel, top - 1 + j) + left - 1;
    const float* variance = state.variance.row(channel, top - 1 + j) + left - 1;
    for (int i = 0; i < 4; ++i) {
      if (variance[i] >= unseen_variance) return std::nullopt;
      sum += row[i], squares += row[i] * row[i];
    }
    carried[j] = between(row, across);
  }
  const float expected = between(carried, down), mean = sum / 16;
  const float contrast = squares / 16 - mean * mean;
  if (contrast < kMinContrast * tables.variance(channel, mean)) return std::nullopt;
  const float off = tables.radiance(channel, code) - expected;
  return off * off / contrast;
}

float TextureError::share() const {
  // What the motion's errors leave of sharp pictures, and how more than that is believed. A share of more
  // than kMost is a failure of the motion or of the response, not of pixels.
  constexpr float kOfMatches = 0.06f, kSlope = 5, kMost = 0.18f;
  return std::clamp(kSlope * (disagreement_ - kOfMatches), least_, kMost);
}

}  // namespace hdrcam
