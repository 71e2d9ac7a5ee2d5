// The cycle that trigger tests drive, and how. Include last: it brings Catch2.
#pragma once

#include <span>

#include "capture/pulse_train.h"

#include "tests/contracts/expect.h"

namespace hdrcam::test {

inline constexpr Exposure kTriggerCycle[] = {
    {std::chrono::milliseconds(1), 1}, {std::chrono::milliseconds(4), 1}, {std::chrono::milliseconds(16), 1}};

inline ExposureSchedule schedule_of(std::span<const Exposure> cycle) {
  return value_of(ExposureSchedule::observed(cycle));
}

inline TriggerOptions options_of(TriggerMode mode, Duration interval = std::chrono::milliseconds(20)) {
  return {.mode = mode, .interval = interval};
}

}  // namespace hdrcam::test
