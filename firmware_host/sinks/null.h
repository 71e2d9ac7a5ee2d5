// The sink that keeps nothing: to measure the pipeline without a disk.
#pragma once

#include "firmware_host/sinks/frame_sink.h"

namespace hdrcam {

class NullSink : public FrameSink {
 public:
  Result<void> emit(const HdrFrame&) override { return ++frames_, Result<void>{}; }
  Result<void> finish() override { return {}; }
  int frames() const { return frames_; }

 private:
  int frames_ = 0;
};

}  // namespace hdrcam
