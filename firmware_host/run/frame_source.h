// Where the frames of a run come from, and at whose pace: a recording that is read as fast as it is taken, or
// a camera that waits for nobody. Everything that tells `replay` from `live` is behind this interface.
// Thread-bound, but for status().
#pragma once

#include <optional>
#include <string>

#include "firmware_host/run/progress.h"
#include "firmware_host/sinks/run_record.h"
#include "firmware_host/sinks/sink_set.h"
#include "hal/core/frame.h"
#include "hal/core/result.h"

namespace hdrcam {

class FrameSource {
 public:
  virtual ~FrameSource() = default;

  virtual const CameraFacts& camera() const = 0;
  virtual RunPace pace() const = 0;
  // Frames to come, where that is known before.
  virtual std::optional<int> frame_count() const { return std::nullopt; }

  // Frames begin to come. Errors: those of the camera.
  virtual Result<void> start() { return {}; }
  // The next frame, valid until the next call; null at the end, also when the user stopped the run. Errors:
  // those of the camera or the file.
  virtual Result<const RawFrame*> next() = 0;
  // An HDR frame left: what the source knows of its way is added to its record.
  virtual void emitted(FrameRecord&) {}
  // What the fit found out about the camera: codes 0..255 to relative exposure, and the black level.
  virtual void learn_response(const Response::Curve&, const BlackLevel&) {}
  // The run is over: what the source counted is added to its record. Errors: why it ended before its time,
  // where that has not been said yet.
  virtual Result<void> finish(RunRecord& record) = 0;

  // How far the run is, in one line. From any thread.
  virtual std::string status(const ProgressState& progress) const { return progress_line(progress); }
};

}  // namespace hdrcam
