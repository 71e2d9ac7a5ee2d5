// Time codes as film and television count them. Reentrant.
#pragma once

#include "hal/core/instant.h"

namespace hdrcam {

// SMPTE ST 12-1, non-drop.
struct TimeCode {
  int hours = 0, minutes = 0, seconds = 0, frame = 0;

  friend bool operator==(const TimeCode&, const TimeCode&) = default;
};

// The code of an instant `since_start` (>= 0) after 00:00:00:00: of the frame that began last, or begins
// within half a frame of a camera of 30 Hz or, if that is faster, of this one; the hours wrap at 24. Of a
// camera of 24, 30 or 60 Hz / 1.001 each second counts 24, 30 or 60 frames and lasts 1.001 s.
TimeCode time_code(Duration since_start, double framerate_hz);

}  // namespace hdrcam
