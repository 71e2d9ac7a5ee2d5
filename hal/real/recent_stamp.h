// Drivers stamp frames and edges with one of the machine's clocks, and not all say with which one.
// Thread-safe.
#pragma once

#include "hal/clock.h"

namespace hdrcam {

// A stamp of which only this is known: it was taken in the last seconds. The clock is the one that shows
// about that time now; where two do (boot and monotonic, until the first suspend) they agree.
Instant instant_of_recent_stamp(Clock& clock, Duration stamp);

}  // namespace hdrcam
