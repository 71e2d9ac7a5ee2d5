#include "capture/trigger_link.h"

#include <fmt/format.h>

#include "hal/core/counted.h"

namespace hdrcam {

Result<void> TriggerLink::start(const ExposureSchedule& schedule) {
  if (trigger_ == nullptr) return {};
  ledger_.start(trigger_->options());
  frames_since_failure_ = 0;
  return trigger_->start(schedule);
}

Result<void> TriggerLink::follow(const ExposureSchedule& schedule) {
  return trigger_ == nullptr ? Result<void>() : trigger_->follow(schedule);
}

void TriggerLink::stop() {
  if (trigger_ != nullptr) trigger_->stop();
}

void TriggerLink::drain(FrameMatcher& matcher) {
  if (trigger_ == nullptr) return;
  while (const auto pulse = trigger_->take()) {
    matcher.trigger(*pulse);
    ledger_.pulse(*pulse);
  }
}

void TriggerLink::answer(const Edge& edge) {
  if (trigger_ != nullptr) ledger_.answer(edge);
}

void TriggerLink::settle(Instant now) {
  if (trigger_ != nullptr) ledger_.settle(now + -trigger_->options().interval / 2);
}

void TriggerLink::settle_last() {
  if (trigger_ == nullptr) return;
  ledger_.end(trigger_->driven());
  settle(trigger_->now());
}

Result<void> TriggerLink::check_driven() {
  constexpr int kMostExposedBefore = 8;
  if (trigger_ == nullptr) return {};
  const auto failure = trigger_->failure();
  if (!failure || ++frames_since_failure_ <= kMostExposedBefore) return {};
  return *failure;
}

bool TriggerLink::held_up(std::uint64_t driven_before, Duration waited) const {
  if (trigger_ == nullptr || trigger_->failure()) return false;
  const auto due = static_cast<std::uint64_t>(waited / trigger_->options().interval);
  return trigger_->driven() - driven_before < due / 2;
}

Error TriggerLink::no_answer(const Error& failed_wait) const {
  if (trigger_ == nullptr || failed_wait.code != ErrorCode::Timeout) return failed_wait;
  if (const auto failure = trigger_->failure()) return *failure;
  return {
      ErrorCode::Timeout,
      fmt::format("{}, though {} {} driven on trigger line '{}'; check the wiring, and that the sensor is in "
                  "its external trigger mode",
                  failed_wait.message, counted(trigger_->driven(), "pulse"),
                  trigger_->driven() == 1 ? "was" : "were", trigger_->line())};
}

}  // namespace hdrcam
