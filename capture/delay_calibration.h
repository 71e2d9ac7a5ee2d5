// Measures from pictures after how many frames a control acts, for cameras of unknown delay (and drivers that
// apply a control when it is queued and report nothing). The camera is given a pattern of two exposures, the
// m-sequence of period 31, which correlates with none of its shifts; ratios of neighbouring pictures show
// which shift occurred. Scene changes, clipping and lost frames only cost comparisons; undecidable pictures
// give an unknown delay. Thread-bound; bounded state.
#pragma once

#include <atomic>
#include <optional>
#include <string>

#include "capture/exposure.h"
#include "capture/pixel_unpack.h"

namespace hdrcam {

struct DelayEstimate {
  std::optional<int> delay;  // frames from the request's own frame to the frame that shows its exposure
  double confidence = 0;     // posterior probability, all delays being equally likely before
  int comparisons = 0;       // pairs of pictures that could be compared
  int agreed = 0;            // of them, those that the best delay explains
  std::string reason;        // one clause, where the delay is unknown

  double agreement() const { return comparisons > 0 ? static_cast<double>(agreed) / comparisons : 0; }
};

// Two exposures that differ in time measure the exposure delay; two that differ in gain measure the gain
// delay.
struct DelayMeasurement {
  Exposure shorter, longer;         // at least a stop apart
  StreamMode mode;                  // that the camera is configured to
  int buffers;                      // as many requests are queued at the start, or as many as it takes
  PixelUnpackSettings unpack = {};  // of its pictures
  int frames = 120;                 // it ends after so many, or twice their time where many are lost
};

// Starts the camera, which is configured, runs the calibration and stops it. Errors: the camera's own; those
// of DropStreak; Interrupted at the next frame after `stop`; an unknown delay is not an error.
Result<DelayEstimate> measure_delay(Camera& camera, const DelayMeasurement& how,
                                    const std::atomic<bool>& stop);

}  // namespace hdrcam
