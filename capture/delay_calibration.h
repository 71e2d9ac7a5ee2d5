// Measures from pictures after how many frames a control acts, for cameras of unknown delay (and drivers that
// apply a control when it is queued and report nothing). The camera is given a pattern of two exposures, the
// m-sequence of period 31, which correlates with none of its shifts; ratios of neighbouring pictures show
// which shift occurred. Scene changes, clipping and lost frames only cost comparisons; undecidable pictures
// give an unknown delay. Thread-bound; bounded state.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <string>

#include "capture/control_latency.h"
#include "capture/exposure.h"
#include "capture/photometry.h"
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

class DelayCalibration {
 public:
  static constexpr int kEnough = 16;  // comparisons

  // Two exposures at least a stop apart; they differ in the control to be measured, time or gain.
  DelayCalibration(const Exposure& shorter, const Exposure& longer, const PhotometricResponse& response);

  // The exposure for the next request.
  Exposure next();
  // Frame `index` arrived (lost frames count); `asked` is the exposure requested for the frame after it.
  void observe(std::uint64_t index, const PhotometricSignature& picture, const Exposure& asked);
  // What observe() does with `asked`; alone for a frame whose picture cannot be read, which used up its
  // request as any other.
  void note_request(std::uint64_t index, const Exposure& asked);
  // Before either: the exposure requested for the frame that arrived was written late or never. Which
  // exposure the frame shows that should show it is unknown, whatever the delay.
  void written_late() { asked_[newest_ % kHistory].reset(); }

  DelayEstimate estimate() const;
  const Photometer& photometer() const { return photometer_; }

 private:
  static constexpr int kHistory = 64;
  // 1 for the longer exposure, 0 for the shorter, nullopt where no request is known.
  std::optional<int> asked_during(std::uint64_t index, int delay) const;

  std::array<Exposure, 2> exposures_;
  double log_step_;
  Photometer photometer_;
  unsigned register_ = 1;
  std::array<std::optional<int>, kHistory> asked_{};
  std::uint64_t newest_ = 0;
  std::optional<PhotometricSignature> last_picture_;
  std::uint64_t last_index_ = 0;
  std::array<int, kMaxDelay + 1> hits_{}, misses_{};
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
