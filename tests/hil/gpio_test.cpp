// Lines of the kernel's simulated GPIO chip.
#include "hal/real/enumerate.h"
#include "hal/real/sync_line_gpiod.h"
#include "hal/real/trigger_line_gpiod.h"
#include "tests/contracts/expect.h"
#include "tests/contracts/sync_line_contract.h"
#include "tests/hil/bed.h"

namespace hdrcam::hil {
namespace {

TEST_CASE("a GPIO input keeps the sync line contract") {
  const SimulatedPin pin(1);
  keeps_input_line_contract({.name = "gpio",
                             .open = [] { return open_gpio_line({.line = "STROBE"}); },
                             .drive = [&](bool active) { pin.drive(active); }});
}

TEST_CASE("a GPIO output keeps the trigger line contract") {
  const SimulatedPin pin(0);
  keeps_output_line_contract({.name = "gpio",
                              .open = [] { return open_trigger_gpio({.line = "gpiochip0:0"}); },
                              .level = [&] { return pin.level(); }});
}

TEST_CASE("a GPIO line that is held by another is refused with the holder's name") {
  const auto heard = open_gpio_line({.line = "HELD"});
  require_error(heard, ErrorCode::Busy);
  CHECK(heard.error().message.find("'pwm-fan'") != std::string::npos);
  const auto driven = open_trigger_gpio({.line = "gpiochip0:2"});
  require_error(driven, ErrorCode::Busy);
  CHECK(driven.error().message.find("'pwm-fan'") != std::string::npos);
}

TEST_CASE("a GPIO line is one line, by its name and by its place") {
  CHECK(same_gpio_line("FSYNC", "gpiochip0:0"));
  CHECK(same_gpio_line("gpiochip0:1", "STROBE"));
  CHECK_FALSE(same_gpio_line("FSYNC", "STROBE"));
  CHECK_FALSE(same_gpio_line("gpiochip0:0", "gpiochip0:1"));
}

TEST_CASE("GPIO lines that are not there are named") {
  for (const char* line : {"NOSUCH", "gpiochip0:99", "gpiochip77:0"}) {
    const auto missing = open_gpio_line({.line = line});
    require_error(missing, ErrorCode::NotFound);
    CHECK(missing.error().message.find(line) != std::string::npos);
  }
}

TEST_CASE("the list of devices names cameras of both kinds and GPIO lines") {
  const UsbCamera plugged(1);
  std::string text;
  for (const FoundDevice& device : list_devices()) {
    text += device.id + " | " + device.title + "\n";
    for (const auto& fact : device.facts) text += "  " + fact + "\n";
    for (const auto& missing : device.missing) text += "  ! " + missing + "\n";
  }
  INFO(text);
  for (const char* part : {"libcamera:\\_SB_.HIL0", "vimc", "vivid", "/dev/video", "gpiochip0:1 STROBE",
                           "held by 'pwm-fan'", "exposure 100.0 to 1000000.0 us", "YUYV: 320x240@60"})
    CHECK(text.find(part) != std::string::npos);
}

}  // namespace
}  // namespace hdrcam::hil
