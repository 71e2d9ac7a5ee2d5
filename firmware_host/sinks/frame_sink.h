// A receiver of HDR frames. A sink gets every emitted frame in the order of emission, with its input frame
// and its processing record; then finish() when the stream has ended, also after ^C; then conclude() with the
// record of the whole run. A sink that fails ends the run: no frame is lost silently. One thread at a time
// calls a sink.
#pragma once

#include "capture/exposed_frame.h"
#include "firmware_host/sinks/run_record.h"
#include "hal/core/result.h"
#include "render/hdr_frame.h"

namespace hdrcam {

// One emitted frame; everything is valid during the call.
struct EmittedFrame {
  const HdrFrame& hdr;
  const ExposedFrame& input;
  const FrameRecord& record;
};

// What a sink looks at of a frame's input. A queue copies no more than that.
enum class InputUse { Facts, Codes };

class FrameSink {
 public:
  virtual ~FrameSink() = default;
  virtual InputUse input_use() const { return InputUse::Facts; }
  // The sink copies what it needs later. Errors: those of the disk.
  virtual Result<void> emit(const EmittedFrame& frame) = 0;
  // Completes everything that is not yet on disk.
  virtual Result<void> finish() { return {}; }
  // Writes the outputs about the whole run; after finish().
  virtual Result<void> conclude(const RunRecord&) { return {}; }
};

}  // namespace hdrcam
