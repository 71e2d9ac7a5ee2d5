// Where HDR frames go. The pipeline hands every emitted frame to each sink in turn, on one thread, and calls
// finish() once at the end, also after ^C. A sink that fails ends the run: a frame is never lost in silence.
// Thread-bound.
#pragma once

#include "hal/core/result.h"
#include "render/hdr_frame.h"

namespace hdrcam {

class FrameSink {
 public:
  virtual ~FrameSink() = default;
  // The frame is the caller's; what the sink needs later it copies. Errors: those of the disk.
  virtual Result<void> emit(const HdrFrame& frame) = 0;
  // Completes what is not yet on disk.
  virtual Result<void> finish() = 0;
};

}  // namespace hdrcam
