// A line that drives a sensor: each pulse on it begins a frame, and in a sensor's external trigger mode the
// width of the pulse is the exposure. Real (libgpiod), simulated, faulty. Thread-bound; the line is left
// inactive when it goes out of scope.
#pragma once

#include <string>

#include "hal/core/instant.h"
#include "hal/core/result.h"

namespace hdrcam {

// What a pulse makes the sensor do.
enum class TriggerMode {
  Off,
  FrameStart,  // its leading edge begins a frame, whose exposure the camera's controls set (FSYNC, XVS)
  PulseWidth,  // the sensor exposes for as long as the line is active
};

enum class LineLevel { Inactive, Active };

// A change of the level. No kernel says when a line changed: only that it did within the call.
struct DrivenEdge {
  Instant at;          // the middle of the call
  Duration within{0};  // half the time that the call took
};

class TriggerLine {
 public:
  virtual ~TriggerLine() = default;
  virtual const std::string& name() const = 0;
  // Sets the level and returns when. Unplugged, Io.
  virtual Result<DrivenEdge> drive(LineLevel level) = 0;
};

}  // namespace hdrcam
