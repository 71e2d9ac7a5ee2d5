// Drivers stamp frames and edges with one of the machine's clocks, and not all report which one.
// Thread-safe.
#pragma once

#include "hal/clock.h"

namespace hdrcam {

// Converts a stamp of an unknown clock, taken in the last seconds. The clock is the one whose time is near
// the stamp now; where two are (boot and monotonic, until the first suspend), they agree. What is there was
// not stamped later than now: a driver's slip into the future is taken for now, so that no frame seems to be
// lost.
Instant instant_of_recent_stamp(Clock& clock, Duration stamp);
// The same of a stamp whose clock its driver states. One that lies far ahead of that clock is of another one,
// as of a USB camera with `uvcvideo clock=CLOCK_REALTIME`, whose driver goes on to state the monotonic clock.
Instant instant_of_recent_stamp(Clock& clock, ClockDomain domain, Duration stamp);

}  // namespace hdrcam
