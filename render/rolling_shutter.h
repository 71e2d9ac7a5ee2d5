// Rolling shutter correction. A sensor that reads row after row exposes the lower ones later: what moves
// sideways leans, what moves down or up is stretched or squeezed. Where the read-out time is known a finished
// frame is put back, each pixel along its motion, to the one moment that its time stamp states: that of the
// middle row. Thread-bound; deterministic for any number of threads.
#pragma once

#include "online/frame_estimate.h"
#include "render/hdr_frame.h"

namespace hdrcam {

class RollingShutterCorrection {
 public:
  explicit RollingShutterCorrection(WorkerPool& pool) : pool_(pool) {}

  // Radiance, all layers and points of the frame. Motion goes on as from the previous frame, that of the
  // first frame as to the next one; a frame of which no motion or no interval is known, or one of less than
  // half of the read-out time, stays as it is.
  // readout_s: of all rows, as in FrameFacts.
  void correct(const FrameEstimate& estimate, double readout_s, HdrFrame& frame);

 private:
  struct Motion {
    const Image<float>& vectors;  // to a neighbour
    float time;                   // from the frame to that neighbour, in intervals: 1 or -1
    float row_time;               // from a row's exposure to the next one's, in intervals
  };
  void find_sources(const Motion& motion);
  void move_layers(HdrFrame& frame);
  void move_points(const Motion& motion, HdrFrame& frame) const;

  WorkerPool& pool_;
  // [dx dy, rows, cols] pixels: from where something is at the frame's moment to where its row saw it;
  // borrowed during a call.
  Image<float> sources_;
  Image<float> moved_;
  Image<std::uint8_t> provenance_;
};

}  // namespace hdrcam
