// The source of a run's frames and its pace: a recording that is read as fast as the fit takes it, or a
// camera that does not wait. This interface hides all differences between `replay` and `live`. Thread-bound,
// except status().
#pragma once

#include <optional>
#include <string>

#include "capture/exposure_limits.h"
#include "firmware_host/run/backlog.h"
#include "firmware_host/run/progress_state.h"
#include "firmware_host/run_pace.h"
#include "firmware_host/sinks/run_control.h"
#include "firmware_host/sinks/run_record.h"
#include "hal/core/frame.h"
#include "hal/core/result.h"

namespace hdrcam {

class FrameSource {
 public:
  virtual ~FrameSource() = default;

  virtual const CameraFacts& camera() const = 0;
  virtual RunPace pace() const = 0;
  // The number of frames, where it is known in advance.
  virtual std::optional<int> frame_count() const { return std::nullopt; }

  // Starts the source. Errors: those of the camera.
  virtual Result<void> start() { return {}; }
  // The next frame, valid until the next call; null at the end, also when the user stopped the run. Errors:
  // those of the camera or the file.
  virtual Result<const RawFrame*> next() = 0;
  // The frames that wait behind the one that next() returned.
  virtual Backlog backlog() const { return Backlog::Unknown; }
  // Called for each emitted HDR frame: adds the source's values to its record.
  virtual void emitted(FrameRecord&) {}
  // Called for each frame that is not emitted, to hold the deadline.
  virtual void left_out() {}
  // Takes the fit's estimates of the camera: codes 0..255 to relative exposure, and the black level.
  virtual void learn_response(const Response::Curve&, const BlackLevel&) {}
  // What the fit may ask of the exposures; none where they stay as they are. Not after follow().
  virtual std::optional<ExposureLimits> exposure_limits() const { return std::nullopt; }
  // Takes the cycle that the fit asks for, within those limits; later frames have it. Errors: those of the
  // camera that cannot do it; the cycle before goes on.
  virtual Result<void> follow(const std::vector<Exposure>&) { return {}; }
  // Ends the run and adds the source's counters to its record. Errors: why it ended early, if not yet
  // reported.
  virtual Result<void> finish(RunRecord& record) = 0;

  // What people who watch the run may ask of it; null where there is nothing to ask.
  virtual RunControl* control() { return nullptr; }

  // The progress of the run in one line. May be called from any thread.
  virtual std::string status(const ProgressState& progress) const { return progress_line(progress); }
};

}  // namespace hdrcam
