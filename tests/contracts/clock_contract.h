// The requirements of every Clock: the machine's, the virtual and the replayed one. See camera_contract.h.
#pragma once

#include <functional>
#include <string>

#include "hal/clock.h"

namespace hdrcam {

struct ClockUnderTest {
  std::string name;
  Clock& clock;
  // The time of the other clocks now, as a driver would stamp it.
  std::function<Duration(ClockDomain)> stamp;
  Duration tolerance = std::chrono::milliseconds(2);  // of a conversion
};

void keeps_clock_contract(const ClockUnderTest& clock);

}  // namespace hdrcam
