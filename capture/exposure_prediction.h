// Predicts the exposure of a frame from the controls that were written some frames before it, as many as each
// control takes to act. Pictures that are unanimous feed back: a missed frame start or a wrong delay makes
// every prediction late or early, and is corrected within a cycle. Thread-bound; bounded state, no
// allocation.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "capture/control_history.h"
#include "capture/control_latency.h"
#include "capture/exposure_proof.h"

namespace hdrcam {

class ExposurePrediction {
 public:
  // nullopt: the delays are unknown, and nothing is predicted.
  explicit ExposurePrediction(const std::optional<ControlDelays>& delays) : delays_(delays) {}

  // Of the newest frame; nullopt where it is unknown what was written for it.
  std::optional<ExposureClaim> predict(const ControlHistory& history) const {
    return predict(history, history.newest_frame(), shift_);
  }
  // Whether the controls behind the prediction were written so late, or never, that the frame may show
  // others: no request before it with the same controls was written in time.
  bool doubtful(const ControlHistory& history) const;
  // The request that the newest frame shows, by the slower of its controls; null where it is unknown.
  const ControlHistory::Request* shown(const ControlHistory& history) const;

  // Takes the exposure (ln E) that pictures and strobe alone found for the newest frame.
  void learn(const ControlHistory& history, double log_value);
  // Frames by which predictions are shifted so far, and how often that changed.
  int shift() const { return shift_; }
  int relocks() const { return relocks_; }

 private:
  static constexpr int kObservations = 3, kMaxShift = 4;
  static constexpr int kMostQueued = kMostBuffers + 1;  // requests: one waits for a free buffer
  static constexpr int kReach = kMaxDelay + kMaxShift;  // frames that a prediction looks back
  static_assert(kReach < ControlHistory::kFrames && kReach + kMostQueued < ControlHistory::kRequests);

  struct Observation {
    std::uint64_t frame = 0;
    double log_value = 0;
  };

  std::optional<ExposureClaim> predict(const ControlHistory& history, std::uint64_t frame, int shift) const;
  bool explains(const ControlHistory& history, int shift) const;

  std::optional<ControlDelays> delays_;
  std::array<Observation, kObservations> observations_{};  // the last ones, the newest at the end
  int observation_count_ = 0, shift_ = 0, relocks_ = 0;
};

}  // namespace hdrcam
