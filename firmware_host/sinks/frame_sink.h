// Where HDR frames go. A sink gets every emitted frame in the order of emission, with the frame that came in
// and the record of the work on it; then finish() when the stream has ended, also after ^C; then conclude()
// with the record of the whole run. A sink that fails ends the run: no frame is lost in silence. One thread
// at a time calls a sink.
#pragma once

#include "capture/exposed_frame.h"
#include "firmware_host/sinks/run_record.h"
#include "hal/core/result.h"
#include "render/hdr_frame.h"

namespace hdrcam {

// One frame as it leaves; everything is valid during the call that hands it on.
struct EmittedFrame {
  const HdrFrame& hdr;
  const ExposedFrame& input;
  const FrameRecord& record;
};

class FrameSink {
 public:
  virtual ~FrameSink() = default;
  // What the sink needs later it copies. Errors: those of the disk.
  virtual Result<void> emit(const EmittedFrame& frame) = 0;
  // Completes what is not yet on disk.
  virtual Result<void> finish() { return {}; }
  // Writes what tells of the whole run; after finish().
  virtual Result<void> conclude(const RunRecord&) { return {}; }
};

}  // namespace hdrcam
