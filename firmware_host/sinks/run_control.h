// What people who watch a run may ask of it: the counters of its camera, and the changes that a camera can
// take while it runs. A replay offers neither. One thread at a time calls it, any thread; it outlives the
// sinks.
#pragma once

#include <string>
#include <vector>

#include "firmware_host/sinks/run_record.h"
#include "hal/core/result.h"

namespace hdrcam {

class RunControl {
 public:
  virtual ~RunControl() = default;

  // Frames by outcome, so far: "captured", "dropped.shed"...
  virtual std::vector<NamedValue> counters() const = 0;
  // The file that is being recorded; "" for none.
  virtual std::string recording() const = 0;

  // Records from the next frame on; returns the new file. Errors: Busy while a recording is open, Interrupted
  // where the run ends, Unsupported where the user named no place for recordings, and those of the disk.
  virtual Result<std::string> start_recording() = 0;
  // Errors: NotFound where nothing is recorded.
  virtual Result<void> stop_recording() = 0;
  // Later frames follow this cycle, written as the flags --shutter and --gain are; "" keeps the gain. Errors:
  // Invalid, BadExposure, Timeout where the camera delivers no frame, Unsupported where the camera or --adapt
  // sets the exposures.
  virtual Result<void> change_cycle(const std::string& shutter, const std::string& gain) = 0;
};

}  // namespace hdrcam
