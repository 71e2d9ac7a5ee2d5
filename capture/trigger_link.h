// The trigger of a camera as the thread that captures sees it: starts and stops the pulses, hands those that
// were driven to the matching of frames, and keeps the account of what the sensor answered
// (trigger_ledger.h). Without a trigger it does nothing: the camera paces itself. Thread-bound; no
// allocation per frame.
#pragma once

#include "capture/frame_matcher.h"
#include "capture/trigger.h"
#include "capture/trigger_ledger.h"

namespace hdrcam {

class TriggerLink {
 public:
  // trigger: null, or outlives the link.
  explicit TriggerLink(Trigger* trigger) : trigger_(trigger) {}

  // Null without a trigger.
  const TriggerOptions* options() const { return trigger_ == nullptr ? nullptr : &trigger_->options(); }
  // The pulses set the exposures.
  bool exposes() const { return trigger_ != nullptr && trigger_->options().mode == TriggerMode::PulseWidth; }

  // Errors: those of Trigger.
  Result<void> start(const ExposureSchedule& schedule);
  Result<void> follow(const ExposureSchedule& schedule);
  void stop();

  // Hands the pulses that were driven since the last call to the matcher.
  void drain(FrameMatcher& matcher);
  // An edge of the strobe line.
  void answer(const Edge& edge);
  // Counts pulses and answers that are half an interval older than this.
  void settle(Instant now);
  // The same after stop(), for the last ones.
  void settle_last();
  const TriggerCounters& counters() const { return ledger_.counters(); }

  // Call it for each frame. An error, where the line failed and frames come all the same, of a sensor that
  // goes on by itself: not for those that may have been exposed before.
  Result<void> check_driven();
  // Pulses that were driven since the start; 0 without a trigger.
  std::uint64_t driven() const { return trigger_ == nullptr ? 0 : trigger_->driven(); }
  // Whether less than half of the pulses that are due in this time were driven, though the line works: the
  // process was stopped, or the machine slept.
  bool held_up(std::uint64_t driven_before, Duration waited) const;
  // Why no frame came: a camera that waits for pulses in vain looks like one that hangs.
  Error no_answer(const Error& failed_wait) const;

 private:
  Trigger* trigger_;
  TriggerLedger ledger_;
  int frames_since_failure_ = 0;
};

}  // namespace hdrcam
