// The faults of a simulated camera that a test has requested, and what really happened to its frames. In the
// product no fault is ever set: only sim_bench.h can. Plain values; the camera's lock guards them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "hal/sim/simulated_camera.h"

namespace hdrcam {

// How a frame was really exposed, whatever its buffer reports.
struct TrueExposure {
  std::uint64_t sequence = 0;
  Duration exposure{0};
  double analogue_gain = 1;
  Instant begin;
};

enum class MetadataFault {
  None,
  Missing,  // the buffer reports no exposure
  Late,     // it reports the exposure of the previous buffer
  Doubled,  // it repeats cookie and exposure of the previous buffer
};

enum class ControlFault {
  None,
  Early,    // acts a frame earlier than the delay says (not before its own frame)
  Late,     // a frame later
  Clipped,  // exposures are cut at 2 ms, gains at 1
  Ignored,  // never acts
};

struct SimulatedCamera::InjectedFaults {
  static constexpr std::size_t kHistory = 4096;
  static constexpr Duration kClippedExposure = std::chrono::milliseconds(2);

  std::array<TrueExposure, kHistory> history{};  // of frame n at n % kHistory
  int drops = 0;
  MetadataFault metadata = MetadataFault::None;
  int disturbed_buffers = 0;
  ControlFault control = ControlFault::None;
  int disturbed_requests = 0;
  bool unplugged = false;
};

}  // namespace hdrcam
