// Drives the trigger line of a sensor with the pulses of the schedule. One thread drives (drive_next, run),
// which neither allocates nor waits for another between a pulse's edges; the thread that captures takes what
// was driven, through a ring without a lock. start(), stop() and follow() may be called from any thread.
#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>

#include "capture/pulse_train.h"
#include "hal/clock.h"
#include "hal/trigger_line.h"

namespace hdrcam {

class Trigger {
 public:
  // The clock outlives it.
  Trigger(std::unique_ptr<TriggerLine> line, const TriggerOptions& options, Clock& clock)
      : line_(std::move(line)), clock_(clock), options_(options) {}

  const std::string& line() const { return line_->name(); }
  const TriggerOptions& options() const { return options_; }
  Instant now() const { return clock_.now(); }

  // Pulses an interval apart, the first after one. Errors: those of PulseTrain::check.
  Result<void> start(const ExposureSchedule& schedule);
  // Later pulses follow another schedule. Errors: the same; the schedule before stays.
  Result<void> follow(const ExposureSchedule& schedule);
  // No further pulse; returns when the one being driven has ended.
  void stop();

  // Waits for the time of the next pulse and drives it. False where none is due, or the line failed.
  bool drive_next();
  // Drives while it is started, and waits otherwise, until end().
  void run();
  void end();

  // The next pulse that was driven, in order; none where all were taken. A pulse that is just ending is
  // waited for: its frame may be there before its record.
  std::optional<TriggerPulse> take();
  // Pulses driven since the start, with those that found the ring full and that take() does not return.
  std::uint64_t driven() const { return driven_; }
  // Why no further pulse comes, where the line failed.
  std::optional<Error> failure() const;

 private:
  static constexpr std::size_t kRing = kMostWaitingPulses;

  std::optional<PlannedPulse> next_pulse();
  Result<void> drive(const PlannedPulse& planned);
  void keep(const TriggerPulse& pulse);

  std::unique_ptr<TriggerLine> line_;
  Clock& clock_;
  const TriggerOptions options_;

  std::array<TriggerPulse, kRing> ring_{};
  std::atomic<bool> ending_pulse_{false};
  std::atomic<std::uint64_t> put_{0}, taken_{0}, driven_{0};

  mutable std::mutex mutex_;  // of everything below
  std::condition_variable changed_;
  std::optional<PulseTrain> train_;
  int starts_ = 0;
  bool started_ = false, driving_ = false, ended_ = false;
  std::optional<Error> failure_;
};

}  // namespace hdrcam
