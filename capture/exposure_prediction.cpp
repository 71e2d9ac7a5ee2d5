#include "capture/exposure_prediction.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace hdrcam {

std::optional<ExposureClaim> ExposurePrediction::predict(const ControlHistory& history, std::uint64_t frame,
                                                         int shift) const {
  if (!delays_) return std::nullopt;
  const std::int64_t cause = static_cast<std::int64_t>(frame) + shift;
  const ControlHistory::Request* time = history.written_at(cause - delays_->exposure);
  const ControlHistory::Request* gain = history.written_at(cause - delays_->gain);
  if (time == nullptr || gain == nullptr) return std::nullopt;
  return ExposureClaim{{time->controls.exposure, gain->controls.analogue_gain}, 1, ExposureSource::Predicted};
}

bool ExposurePrediction::doubtful(const ControlHistory& history) const {
  if (!delays_) return false;
  const auto changed_late = [&](int delay, auto control) {
    std::int64_t frame = static_cast<std::int64_t>(history.newest_frame()) + shift_ - delay;
    const ControlHistory::Request* written = history.written_at(frame);
    while (written != nullptr && written->late) {
      const ControlHistory::Request* before = history.written_at(--frame);
      if (before == nullptr || before->controls.*control != written->controls.*control) return true;
      written = before;
    }
    return false;
  };
  return changed_late(delays_->exposure, &ExposureRequest::exposure) ||
         changed_late(delays_->gain, &ExposureRequest::analogue_gain);
}

const ControlHistory::Request* ExposurePrediction::shown(const ControlHistory& history) const {
  const int delay = delays_ ? std::max(delays_->exposure, delays_->gain) - shift_ : 0;
  return history.written_at(static_cast<std::int64_t>(history.newest_frame()) - delay);
}

bool ExposurePrediction::explains(const ControlHistory& history, int shift) const {
  return std::all_of(observations_.begin(), observations_.end(), [&](const Observation& observation) {
    const auto predicted = predict(history, observation.frame, shift);
    return predicted && same_exposure(predicted->log_value(), observation.log_value);
  });
}

// Shifts the prediction when the last frames, with at least two different exposures, all show it late or
// early by the same number of frames. A single late frame does not shift it.
void ExposurePrediction::learn(const ControlHistory& history, double log_value) {
  if (!predict(history)) return;
  std::rotate(observations_.begin(), observations_.begin() + 1, observations_.end());
  observations_.back() = {history.newest_frame(), log_value};
  observation_count_ = std::min(observation_count_ + 1, kObservations);
  const bool various = std::any_of(
      observations_.begin(), observations_.end(),
      [&](const Observation& observation) { return !same_exposure(observation.log_value, log_value); });
  if (observation_count_ < kObservations || !various || explains(history, shift_)) return;
  // an observation so old that its controls are forgotten contradicts nothing
  const bool remembered = std::all_of(
      observations_.begin(), observations_.end(),
      [&](const Observation& observation) { return predict(history, observation.frame, shift_); });
  if (!remembered) return;
  for (int distance = 1; distance <= kMaxShift; ++distance) {
    for (const int shift : {shift_ - distance, shift_ + distance}) {
      if (std::abs(shift) > kMaxShift || !explains(history, shift)) continue;
      shift_ = shift;
      ++relocks_;
      return;
    }
  }
}

}  // namespace hdrcam
