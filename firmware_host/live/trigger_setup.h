// From the settings of the lines to lines that are open: the strobe that a sensor answers on, the trigger
// that drives it with its thread, and the guard that leaves it inactive when this process is killed.
// Thread-bound.
#pragma once

#include <memory>
#include <optional>

#include "capture/captured_frame.h"
#include "capture/trigger_thread.h"
#include "firmware_host/settings/settings.h"
#include "hal/real/last_act.h"
#include "hal/sim/simulated_camera.h"
#include "hal/sync_line.h"

namespace hdrcam {

// Errors: Invalid for lines that contradict each other, the camera or the trigger; Unsupported for a trigger
// with a camera that cannot be triggered. They name the lines.
Result<void> check_lines(const Settings& settings);

// The lines of one camera. The camera is opened between prepare() and open(), and ends before them.
class CameraLines {
 public:
  // Starts the guard, before the program has other threads. Errors: those of check_lines().
  static Result<std::unique_ptr<CameraLines>> prepare(const Settings& settings);

  // The wires of a simulated camera that uses them.
  SimulatedWiring wiring();
  // interval: between frames. Errors: those of the lines (NotFound, Permission, Busy, Unsupported).
  Result<void> open(Duration interval);

  SyncLine* strobe() { return strobe_.get(); }
  Trigger* trigger() { return trigger_.get(); }
  // What the user should know at the start; "" for nothing.
  std::string note() const;
  // The sentence of the end (trigger_ledger.h), with what to check where many frames do not fit the pulses;
  // "" without a trigger.
  std::string sentence(const CaptureCounters& camera) const;
  // What to check where the strobe line has no pulse for any of these frames, or for many one of another
  // width; "" where all fit, or there is none.
  std::string strobe_sentence(const CaptureCounters& camera) const;
  bool realtime() const { return thread_ && thread_->realtime().ok(); }

 private:
  explicit CameraLines(const Settings::Sync& sync) : sync_(sync) {}
  Result<TriggerOptions> options(Duration interval) const;

  const Settings::Sync sync_;
  std::unique_ptr<LastAct> guard_;  // first here, last to go
  std::unique_ptr<SimulatedWire> strobe_wire_, trigger_wire_;
  std::unique_ptr<SyncLine> strobe_;
  std::unique_ptr<Trigger> trigger_;
  std::optional<TriggerThread> thread_;
};

}  // namespace hdrcam
