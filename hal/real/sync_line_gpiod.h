// The strobe line of a sensor on a GPIO pin, through libgpiod. In a build without it every call returns
// Unsupported and names the package to install. Thread-bound as hal/sync_line.h says.
#pragma once

#include <memory>

#include "hal/real/gpio_line.h"
#include "hal/sync_line.h"

namespace hdrcam {

// NotFound, Permission, Busy (names the holder), Unsupported.
Result<std::unique_ptr<SyncLine>> open_gpio_line(const GpioSettings& settings);

}  // namespace hdrcam
