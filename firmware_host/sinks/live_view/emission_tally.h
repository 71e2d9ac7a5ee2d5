// Running figures of the frames that a live view got: how many, how fast, what each stage took in all, the
// verdicts and the exposures in use. A fixed amount of memory for a run of any length. Thread-safe.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <iterator>
#include <mutex>
#include <vector>

#include "firmware_host/sinks/frame_sink.h"

namespace hdrcam {

// An exposure of the cycle, as recent frames had it.
struct ExposureInUse {
  double time_s = 0, gain = 1;
  double relative = 1;  // E / E_ref: it saturates at radiance 1 / relative
};

struct EmissionFigures {
  using Clock = std::chrono::steady_clock;

  std::uint64_t frames = 0;
  Clock::time_point begin{}, newest{};                         // newest: none without frames
  double per_second = 0;                                       // of the latest frames
  double latency_ms = 0;                                       // of the newest frame, on a camera
  double processing_ms = 0;                                    // in all
  FrameValues stages_ms = {};                                  // in all
  std::array<std::uint64_t, std::size(kVerdicts)> verdicts{};  // by enum Verdict
  std::vector<ExposureInUse> exposures = {};                   // short to long
};

class EmissionTally {
 public:
  void count(const EmittedFrame& frame);
  EmissionFigures figures() const;

 private:
  using Clock = EmissionFigures::Clock;
  static constexpr std::size_t kRecent = 16;  // four cycles of four exposures

  mutable std::mutex mutex_;
  EmissionFigures sums_{.begin = Clock::now()};
  std::array<Clock::time_point, kRecent> times_{};  // rings
  std::array<ExposureInUse, kRecent> exposures_{};
};

}  // namespace hdrcam
