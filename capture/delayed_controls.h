// Holds back the faster of two controls. Exposure and gain act some frames after they are written, each after
// its own delay; written together, a frame would show the time of one request and the gain of another.
//
//   frame start      s        s+1      s+2         exposure acts after 2, gain after 1
//   request          A        B        C
//   written          A.time   B.time   C.time      the gain is held back by one frame
//                    -        A.gain   B.gain
//   frame shows                        A
//
// As libcamera's DelayedControls does (src/libcamera/pipeline/rpi/common/delayed_controls.cpp). Thread-bound;
// no allocation.
#pragma once

#include <array>
#include <cstdint>

#include "capture/control_latency.h"
#include "hal/camera.h"

namespace hdrcam {

class DelayedControls {
 public:
  // delays: 0..kMaxDelay. now: the sensor's settings before the first request.
  DelayedControls(const ControlDelays& delays, const ExposureRequest& now);

  // The next request as it is to be written, under its own cookie: with its own value of the slower control,
  // and of the faster one that of as many requests before as their delays differ.
  ExposureRequest held_back(const ExposureRequest& request);

 private:
  const ExposureRequest& before(int requests) const;

  ControlDelays held_;                                     // frames by which each control is held back
  ExposureRequest now_;                                    // until the first request
  std::array<ExposureRequest, kMaxDelay + 1> requests_{};  // the n-th at n % their number
  std::uint64_t count_ = 0;
};

}  // namespace hdrcam
