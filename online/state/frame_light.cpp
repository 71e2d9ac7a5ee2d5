#include "online/state/frame_light.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "capture/clip_policy.h"
#include "capture/exposure.h"
#include "hal/core/inline_list.h"
#include "hal/core/median.h"
#include "online/pictures/between_pixels.h"

namespace hdrcam {
namespace {

constexpr float kDarkest = 16;      // codes: below, black level and toe decide
constexpr int kLookedAt = 1500;     // pixels, of a picture of any size: their median errs by half a percent
constexpr std::size_t kOneIn = 20;  // of them tells: fewer may all be of one thing

}  // namespace

// The median over pixels that both know. Wrong motion makes some brighter and others darker.
std::optional<float> FrameLight::beyond_state(const StateComparison& seen) {
  const Image<float>& vectors = seen.to_previous.vectors;
  if (vectors.empty()) return std::nullopt;
  const int rows = seen.frame.codes.rows(), cols = seen.frame.codes.cols();
  const int stride = std::max(1, static_cast<int>(std::sqrt(rows * cols / kLookedAt)));
  std::size_t looked_at = 0;
  ratios_.clear();
  for (int y = stride / 2; y < rows; y += stride)
    for (int x = stride / 2; x < cols; x += stride) {
      const int channel = static_cast<int>(looked_at++ % 3);  // by turns
      const float code = seen.frame.codes.at(channel, y, x);
      if (code < kDarkest || code > clip_policy::kCompareFadeBegin) continue;
      const BetweenPixels place(rows, cols, x, y, offset_at(vectors, x, y));
      const float light = place.of(seen.state.radiance, channel);
      if (light > 0 && place.of(seen.state.variance, channel) < seen.unseen_variance)
        ratios_.push_back(seen.tables.radiance(channel, code) / light);
    }
  if (ratios_.size() * kOneIn < looked_at) return std::nullopt;
  const float ratio = median(ratios_);
  return ratio > 0 ? std::optional(std::log(ratio)) : std::nullopt;
}

void FrameLight::remember(const Light& light) { recent_[count_++ % kRemembered] = light; }

const FrameLight::Light& FrameLight::before(std::size_t age) const {
  return recent_[(count_ - 1 - age) % kRemembered];
}

// From the middle of those of its exposure; 0 where there is no other.
float FrameLight::apart(const Light& light) const {
  InlineList<float, kRemembered> alike;
  for (std::size_t age = 0; age < remembered(); ++age)
    if (same_exposure(static_cast<double>(before(age).log_exposure), static_cast<double>(light.log_exposure)))
      alike.push_back(before(age).beyond);
  std::ranges::sort(alike);
  return std::abs(light.beyond - (alike[(alike.size() - 1) / 2] + alike[alike.size() / 2]) / 2);
}

float FrameLight::unsteadiness() const {
  constexpr std::size_t kParts = 3;
  const std::size_t of_part = remembered() / kParts;
  float least = std::numeric_limits<float>::infinity();
  for (std::size_t part = 0; part < kParts; ++part) {
    float sum = 0;
    for (std::size_t age = part * of_part; age < (part + 1) * of_part; ++age) sum += apart(before(age));
    least = std::min(least, sum / static_cast<float>(of_part));
  }
  return least;
}

float FrameLight::follow(const StateComparison& seen) {
  constexpr float kSteady = 0.015f, kUnsteady = 0.03f;  // ln; of steady light .001 to .006
  constexpr std::size_t kFew = 8;                       // frames
  constexpr float kGoesOn = 1.f / 24;                   // share of a frame: about a second
  constexpr float kMost = 1.4f;                         // ln: two stops; what is more is no flicker
  const std::optional<float> beyond = beyond_state(seen);
  if (!beyond) return 0;
  remember({std::log(seen.frame.exposure), *beyond});
  if (count_ >= kRemembered) expected_ = false;
  if (count_ >= kFew && !expected_) {
    const bool now = unsteadiness() > (unsteady_ ? kSteady : kUnsteady);
    if (now != unsteady_) goes_on_ = 0;
    unsteady_ = now;
  }
  if (!unsteady_) return 0;
  goes_on_ += kGoesOn * (*beyond - goes_on_);
  const float own = std::clamp(*beyond - goes_on_, -kMost, kMost);
  squares_ += static_cast<double>(own * own), ++followed_;
  return own;
}

double FrameLight::spread_stops() const {
  return followed_ > 0 ? std::sqrt(squares_ / static_cast<double>(followed_)) / std::numbers::ln2 : 0;
}

}  // namespace hdrcam
