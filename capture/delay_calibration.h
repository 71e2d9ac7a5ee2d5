// After how many frames does a control act? Measured from pictures, for cameras that nobody has measured
// before (and for drivers that apply a control when it is queued and report nothing). The camera is shown a
// pattern of two exposures, the m-sequence of period 31, which is like none of its shifts; the ratios of
// neighbouring pictures say which shift was seen. A scene that changes, clips or loses frames costs
// comparisons, not the answer; pictures that cannot tell are said to be so. Thread-bound; bounded state.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "capture/control_delay.h"
#include "capture/exposure.h"
#include "capture/photometry.h"
#include "capture/pixel_unpack.h"

namespace hdrcam {

struct DelayEstimate {
  std::optional<int> delay;  // frames from a request's own to the one that shows its exposure
  double confidence = 0;     // posterior probability, all delays being equally likely before
  int comparisons = 0;       // pairs of pictures that could say something
  double agreement = 0;      // share of them that the best delay explains
  std::string reason;        // one clause, where the delay is unknown
};

class DelayCalibration {
 public:
  static constexpr int kMaxDelay = 15;  // sensors need 1..3; a driver that queues internally adds its depth
  static constexpr int kEnough = 16;    // comparisons

  // Two exposures at least a stop apart, by time or by gain: whichever control is measured.
  DelayCalibration(const Exposure& shorter, const Exposure& longer, const PhotometricResponse& response);

  // What the next request should ask for.
  Exposure next();
  // Frame `index` came (counting lost ones); `asked` is what the request of the frame after it asks for.
  void observe(std::uint64_t index, const PhotometricSignature& picture, const Exposure& asked);

  DelayEstimate estimate() const;
  const Photometer& photometer() const { return photometer_; }

 private:
  static constexpr int kHistory = 64;
  // 1 for the longer exposure, 0 for the shorter, nullopt where nothing is known to have been asked.
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

// Runs a camera, configured to `mode` with so many buffers, through the calibration and stops it again. Two
// exposures that differ in time measure the delay of the exposure; two that differ in gain, that of the gain.
// Errors: the camera's own; an unknown delay is no error.
Result<DelayEstimate> measure_delay(Camera& camera, const StreamMode& mode, int buffers,
                                    const Exposure& shorter, const Exposure& longer,
                                    const PixelUnpackSettings& unpack, int frames = 120);

}  // namespace hdrcam
