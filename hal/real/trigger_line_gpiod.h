// The trigger line of a sensor on a GPIO pin, through libgpiod, and a guard that leaves it inactive when this
// process dies. The kernel releases the line of a process that is killed; whether its level falls back then
// is the driver's affair, and most leave it as it was. Thread-bound.
#pragma once

#include <memory>

#include "hal/real/gpio_line.h"
#include "hal/real/last_act.h"
#include "hal/trigger_line.h"

namespace hdrcam {

// Requests the line as an output, inactive. NotFound, Permission, Busy (names the holder), Unsupported.
Result<std::unique_ptr<TriggerLine>> open_trigger_gpio(const GpioSettings& settings);

// A child process that drives the line inactive for kHeldInactive, and lets go of it, when this process ends
// without doing so. Start it before other threads, and before the line is opened.
constexpr Duration kHeldInactive{200'000'000};
Result<std::unique_ptr<LastAct>> guard_trigger_gpio(const GpioSettings& settings);

}  // namespace hdrcam
