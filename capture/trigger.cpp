#include "capture/trigger.h"

#include <thread>

namespace hdrcam {

Result<void> Trigger::start(const ExposureSchedule& schedule) {
  TRY(PulseTrain::check(options_, schedule));
  {
    const std::lock_guard lock(mutex_);
    train_.emplace(options_, schedule);
    train_->start(clock_.now() + options_.interval);
    ++starts_;
    taken_ = put_.load(), driven_ = 0;
    failure_.reset();
    started_ = true;
  }
  changed_.notify_all();
  return {};
}

Result<void> Trigger::follow(const ExposureSchedule& schedule) {
  TRY(PulseTrain::check(options_, schedule));
  const std::lock_guard lock(mutex_);
  if (train_) train_->follow(schedule);
  return {};
}

void Trigger::stop() {
  std::unique_lock lock(mutex_);
  started_ = false;
  changed_.notify_all();
  changed_.wait(lock, [this] { return !driving_; });
}

void Trigger::end() {
  {
    const std::lock_guard lock(mutex_);
    started_ = false, ended_ = true;
  }
  changed_.notify_all();
}

std::optional<Error> Trigger::failure() const {
  const std::lock_guard lock(mutex_);
  return failure_;
}

// The pulse that is to be driven now, or within kAhead.
std::optional<PlannedPulse> Trigger::next_pulse() {
  constexpr Duration kAhead = std::chrono::milliseconds(20);  // stop() waits no longer for a pulse to come
  std::unique_lock lock(mutex_);
  if (!started_) return std::nullopt;
  const PlannedPulse planned = train_->next(clock_.now());
  const auto over = [this, start = starts_] { return !started_ || starts_ != start; };
  if (const Duration left = planned.begin - clock_.now(); left > 2 * kAhead)
    changed_.wait_for(lock, left - kAhead, over);
  if (over()) return std::nullopt;
  driving_ = true;
  return planned;
}

bool Trigger::drive_next() {
  const auto planned = next_pulse();
  if (!planned) return false;
  const Result<void> driven = drive(*planned);
  {
    const std::lock_guard lock(mutex_);
    driving_ = false;
    if (!driven) failure_ = driven.error(), started_ = false;
  }
  changed_.notify_all();
  return driven.ok();
}

// The trailing edge is counted from the leading one as it was driven: a late pulse has its width.
Result<void> Trigger::drive(const PlannedPulse& planned) {
  clock_.sleep_until(planned.not_before);
  const DrivenEdge rise = TRY(line_->drive(LineLevel::Active));
  clock_.sleep_until(rise.at + planned.width);
  ending_pulse_ = true;
  const auto fall = line_->drive(LineLevel::Inactive);
  if (fall) {
    const std::lock_guard lock(mutex_);  // no edge waits for it
    ++driven_;
    keep(train_->driven(planned, rise, fall.value()));
  }
  ending_pulse_ = false;
  return fall ? Result<void>() : fall.error();
}

void Trigger::keep(const TriggerPulse& pulse) {
  const std::uint64_t place = put_;
  if (place - taken_ >= kRing) return;
  ring_[place % kRing] = pulse;
  put_ = place + 1;
}

std::optional<TriggerPulse> Trigger::take() {
  while (ending_pulse_) std::this_thread::yield();
  const std::uint64_t place = taken_;
  if (place == put_) return std::nullopt;
  const TriggerPulse pulse = ring_[place % kRing];
  taken_ = place + 1;
  return pulse;
}

void Trigger::run() {
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return started_ || ended_; });
      if (ended_) return;
    }
    while (drive_next()) {
    }
  }
}

}  // namespace hdrcam
