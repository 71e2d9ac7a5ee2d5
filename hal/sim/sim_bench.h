// The test's side of a simulated camera: what really happened, and harm on order. The product never includes
// this. Thread-safe; the camera outlives the bench.
#pragma once

#include <array>

#include "hal/sim/simulated_camera.h"

namespace hdrcam {

// How a frame was really exposed, whatever its buffer says.
struct TrueExposure {
  std::uint64_t sequence = 0;
  Duration exposure{0};
  double analogue_gain = 1;
  Instant begin;
};

enum class MetadataFault {
  None,
  Missing,  // the buffer reports no exposure
  Late,     // it reports the exposure of the buffer before
  Doubled,  // it repeats cookie and exposure of the buffer before
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

  // Of one of the last 4096 frames of the stream, lost ones included.
  std::optional<TrueExposure> true_exposure(std::uint64_t sequence) const;

  // The next frames are exposed, but lost on the way.
  void drop_next(int frames);
  // The next buffers lie about themselves.
  void disturb_metadata(MetadataFault fault, int buffers);
  // The next requests act otherwise than asked.
  void disturb_controls(ControlFault fault, int requests);
  // The sensor's delays are others from now on.
  void set_delays(ControlDelays delays);
  // The device is gone: wait() and queue() return Unplugged.
  void unplug();

 private:
  SimulatedCamera& camera_;
};

// What a test has ordered; empty in the product.
struct SimulatedCamera::Harm {
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
