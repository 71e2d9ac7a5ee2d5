#include "online/state/shown_blur.h"

#include <algorithm>
#include <cmath>

#include "capture/clip_policy.h"
#include "capture/exposure.h"
#include "online/pictures/between_pixels.h"
#include "online/pictures/sparse_lines.h"

namespace hdrcam {
namespace {

constexpr int kStride = 3;                              // pixels
constexpr float kLeastStated = 0.15f, kMostStated = 3;  // shares of a frame that tells; stills take any time
constexpr float kLeastBlur = 1, kMostBlur = 32;         // pixels
constexpr float kDarkest = 12;                          // codes: below, engines blur by themselves
constexpr float kRelative = 0.02f;                      // of radiance: noise that no model states
constexpr float kMinSize2 = 4;                          // squared blur over the variance of noise
constexpr double kEnough = 100, kMemory = 2000;         // comparisons

// Exposure time over the time since the frame before; 0: unknown.
float share_of(const ExposedFrame& frame) {
  if (frame.blur_fraction > 0) return frame.blur_fraction;
  const bool outlasts =
      frame.facts.has_exposure_time() && outlasts_frame(frame.facts.exposure_s, frame.interval_s);
  return outlasts ? static_cast<float>(frame.facts.exposure_s / frame.interval_s) : 0;
}

}  // namespace

struct ShownBlur::Seen : StateComparison {
  float stated;
};

float ShownBlur::stated(const ExposedFrame& frame) {
  const float share = share_of(frame);
  return share <= kMostStated ? share : 0;
}

void ShownBlur::observe_exposure(const ExposedFrame& frame) {
  // Time stamps jitter: few that are too early prove nothing. The longest exposure of a cycle comes more
  // often than that, and the first one tells where it is much too long.
  constexpr float kBeyondJitter = 1.5f;
  constexpr long kLeast = 2, kOneIn = 10;
  const float share = share_of(frame);
  const bool outlasts = share > 1 && !(frame.blur_fraction > 0);
  ++frames_;
  if (outlasts) ++outlasting_;
  const bool told = doubted_ || outlasting_ >= kLeast || (outlasts && share >= kBeyondJitter);
  const bool doubted = told && outlasting_ * kOneIn >= frames_;
  if (doubted == doubted_) return;
  doubted_ = doubted, shown_ = !doubted;
  forget();
}

void ShownBlur::observe(const StateComparison& compared, float stated) {
  if (compared.to_previous.vectors.empty() || stated < kLeastStated) return;
  if (settling_ > 0) {
    --settling_;
    return;
  }
  const Seen seen{compared, stated};
  const int rows = seen.frame.codes.rows(), cols = seen.frame.codes.cols();
  const int apart = lines_apart(rows, cols, kStride);
  lines_.assign(static_cast<std::size_t>((rows + apart - 1) / apart), {});
  pool_.for_each(static_cast<int>(lines_.size()),
                 [&](int i) { lines_[static_cast<std::size_t>(i)] = compare_line(seen, i * apart); });
  Evidence& e = evidence_;
  const double kept = e.count > kMemory ? 0.5 : 1;
  for (double* sum : {&e.along2, &e.both, &e.across2, &e.by_along, &e.by_across, &e.count}) *sum *= kept;
  for (const Evidence& line : lines_) {
    e.along2 += line.along2, e.both += line.both, e.across2 += line.across2;
    e.by_along += line.by_along, e.by_across += line.by_across, e.count += line.count;
  }
  decide();
}

ShownBlur::Evidence ShownBlur::compare_line(const Seen& seen, int y) {
  Evidence evidence;
  const int rows = seen.frame.codes.rows(), cols = seen.frame.codes.cols();
  for (int x = 0; x < cols; x += kStride) {
    if (seen.to_previous.confidence.at(0, y, x) < kComparedConfidence) continue;
    const Offset motion = offset_at(seen.to_previous.vectors, x, y);
    const float blur = length_of(motion) * seen.stated;
    if (!(blur >= kLeastBlur && blur <= kMostBlur)) continue;
    const float reach = blur / 2 + 2;
    const float from_x = static_cast<float>(x) + motion.x, from_y = static_cast<float>(y) + motion.y;
    if (from_x - reach < 0 || from_y - reach < 0 || from_x + reach > static_cast<float>(cols - 1) ||
        from_y + reach > static_cast<float>(rows - 1))
      continue;
    compare(seen, (x / kStride + y) % 3, y, x, evidence);  // the channels by turns
  }
  return evidence;
}

// The difference between a sample and the carried state, and what the state's blur along and across the
// motion would make of it.
void ShownBlur::compare(const Seen& seen, int channel, int y, int x, Evidence& evidence) {
  const RadianceState& state = seen.state;
  const float code = seen.frame.codes.at(channel, y, x);
  if (code < kDarkest || code > clip_policy::kCompareFadeBegin) return;
  const int rows = seen.frame.codes.rows(), cols = seen.frame.codes.cols();
  const Offset motion = offset_at(seen.to_previous.vectors, x, y);
  bool knows = true;
  const auto light = [&](Offset by) {
    const BetweenPixels place(rows, cols, x, y, {motion.x + by.x, motion.y + by.y});
    knows = knows && place.of(state.variance, channel) < seen.unseen_variance;
    return place.of(state.radiance, channel);
  };
  const float here = light({});
  const int instants = std::max(3, static_cast<int>(length_of(motion) * seen.stated) | 1);
  float along = 0, across = 0;
  for (int i = 0; i < instants && knows; ++i) {
    const float t = seen.stated * ((static_cast<float>(i) + 0.5f) / static_cast<float>(instants) - 0.5f);
    along += light(t * motion);
    across += light(t * Offset{-motion.y, motion.x});
  }
  if (!knows) return;
  const float mean = along / static_cast<float>(instants);
  const float b_along = mean - here, b_across = across / static_cast<float>(instants) - here;
  const float size2 = b_along * b_along + b_across * b_across;
  const float noise = seen.tables.variance(channel, mean) +
                      BetweenPixels(rows, cols, x, y, motion).of(state.variance, channel);
  if (!(size2 >= kMinSize2 * (noise + kRelative * kRelative * here * here))) return;
  const float most = 2 * std::sqrt(size2);  // more is a failure of the motion
  const float off = std::clamp(seen.tables.radiance(channel, code) - here, -most, most);
  const double weight = 1 / static_cast<double>(noise + size2);
  evidence.along2 += weight * static_cast<double>(b_along * b_along);
  evidence.both += weight * static_cast<double>(b_along * b_across);
  evidence.across2 += weight * static_cast<double>(b_across * b_across);
  evidence.by_along += weight * static_cast<double>(off * b_along);
  evidence.by_across += weight * static_cast<double>(off * b_across);
  evidence.count += 1;
}

// A state that took blurred frames for sharp ones, or sharp ones for blurred, has part of that blur itself,
// or of its opposite: along the motion frames then show about half. What also acts across it is no motion
// blur. The more comparisons there are, the less has to speak against what was taken so far.
void ShownBlur::decide() {
  constexpr double kLittle = 0.2, kMuch = 0.35;  // shown beyond what acts across
  constexpr double kHardlyAny = 0.3, kHardlyAnyAcross = 0.1;
  constexpr double kSure = 4;
  constexpr double kApart = 0.1;  // of edges that run along the motion, or at 45 degrees, nothing can be said
  constexpr int kSettling = 6;
  const Evidence& e = evidence_;
  const double determinant = e.along2 * e.across2 - e.both * e.both;
  if (e.count < kEnough || !(determinant > kApart * e.along2 * e.across2) || e.along2 < kApart * e.across2)
    return;
  const double along = (e.across2 * e.by_along - e.both * e.by_across) / determinant;
  const double across = (e.along2 * e.by_across - e.both * e.by_along) / determinant;
  const double beyond = along - across, certainty = std::sqrt(e.count);
  const bool refuted = shown_ ? along < kHardlyAny && (kMuch - beyond) * certainty > kSure
                              : across < kHardlyAnyAcross && (beyond - kLittle) * certainty > kSure;
  if (!refuted) return;
  shown_ = !shown_;
  settling_ = kSettling;
  forget();
}

}  // namespace hdrcam
