// A model of a sensor whose controls act some frames after they are written, each with its own delay. The
// model holds back the faster controls so that all values of one request act on the same frame, and it knows
// which request that is. It is libcamera's DelayedControls
// (src/libcamera/pipeline/rpi/common/delayed_controls.cpp) as a value.
//
//   frame start      s        s+1      s+2         exposure acts after 2, gain after 1
//   request pushed   A        B        C
//   written          A.time   B.time   C.time      the gain is held back by one frame
//                    -        A.gain   B.gain
//   frame shows                        A           shown_by(s + 2) = A, cookie included
//
// After a missed frame start the model disagrees with the sensor for one or a few frames; only the pictures
// show it (exposure_proof.h). Thread-bound; no allocation.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "capture/sensor_table.h"
#include "hal/camera.h"

namespace hdrcam {

class DelayedControls {
 public:
  static constexpr int kHistory = 32;  // requests; older ones are forgotten

  // What to write at a frame start: each value as early as its delay requires, the blanking first.
  struct Writes {
    Duration exposure{0};
    double analogue_gain = 1;
    Duration frame_duration{0};  // vertical blanking, expressed as the resulting frame duration
  };
  struct Latched {
    std::uint64_t cookie = 0;
    Duration exposure{0};
    double analogue_gain = 1;
  };

  // `now`: the sensor's settings before the first frame.
  DelayedControls(const SensorDelays& delays, const ExposureRequest& now, Duration frame_duration);

  // Sets the request for the next frame start. A second push before it replaces the first.
  void push(const ExposureRequest& request, Duration frame_duration);
  // Frame `sequence` begins. Frames between the last start and this one were missed and get the last request
  // again.
  Writes frame_started(std::uint64_t sequence);
  // The request that the frame shows, if no frame start was missed; nullopt where too old or undecided.
  std::optional<Latched> shown_by(std::uint64_t sequence) const;

  const SensorDelays& delays() const { return delays_; }

 private:
  struct Entry {
    ExposureRequest request;
    Duration frame_duration{0};
  };
  Entry& entry(std::uint64_t index) { return ring_[index % kHistory]; }
  const Entry& entry(std::uint64_t index) const { return ring_[index % kHistory]; }

  SensorDelays delays_;
  Entry before_;  // the initial settings
  std::array<Entry, kHistory> ring_{};
  std::uint64_t write_count_ = 0;  // frame starts so far, which is also where the next push goes
};

}  // namespace hdrcam
