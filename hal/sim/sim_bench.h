// A test's access to a simulated camera: what really happened, and faults on request. The product never
// includes this. Thread-safe; the camera outlives the bench.
#pragma once

#include <cstdint>
#include <optional>

#include "hal/sim/injected_faults.h"
#include "hal/sim/simulated_camera.h"

namespace hdrcam {

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

}  // namespace hdrcam
