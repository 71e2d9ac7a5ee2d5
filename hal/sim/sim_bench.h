// A test's access to a simulated camera: what really happened, and faults on request. The product never
// includes this. Thread-safe; the camera outlives the bench.
#pragma once

#include <array>

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

class SimBench {
 public:
  explicit SimBench(SimulatedCamera& camera) : camera_(camera) {}

  // The true exposure of one of the last 4096 frames of the stream, lost ones included.
  std::optional<TrueExposure> true_exposure(std::uint64_t sequence) const;

  // The next frames are exposed but lost.
  void drop_next(int frames);
  // The next buffers report wrong facts.
  void disturb_metadata(MetadataFault fault, int buffers);
  // The next requests do not act as requested.
  void disturb_controls(ControlFault fault, int requests);
  // Unplugs the device: wait() and queue() return Unplugged.
  void unplug();

 private:
  SimulatedCamera& camera_;
};

// The faults that a test has requested; empty in the product.
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
