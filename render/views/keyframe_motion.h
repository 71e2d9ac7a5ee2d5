// The motion between two emitted frames, both ways. It is searched between the pictures themselves, which are
// sharp, denoised and of one exposure, and not taken from the state's motion, which had to be found between a
// state and a frame that may be blurred, clipped or black; the state's motion is where the search starts.
// Thread-bound; the answer does not depend on the number of threads.
#pragma once

#include "online/priors/motion/cpu_flow.h"
#include "render/views/keyframe.h"

namespace hdrcam {

class KeyframeMotion {
 public:
  explicit KeyframeMotion(WorkerPool& pool) : pool_(pool), flow_(pool) {}

  // Fills after.to_previous and after.from_previous. Frames of one size.
  void match(const Keyframe& before, Keyframe& after);

 private:
  void show(const HdrFrame& frame, float white, Image<float>& codes);
  void agree(const FlowField& back, FlowField& flow);

  WorkerPool& pool_;
  CpuFlow flow_;
  Image<float> codes_before_, codes_after_;  // [1, rows, cols] 0..255, logarithmic
};

}  // namespace hdrcam
