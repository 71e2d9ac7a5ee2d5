#include "hal/sim/sim_bench.h"

namespace hdrcam {

std::optional<TrueExposure> SimBench::true_exposure(std::uint64_t sequence) const {
  const std::lock_guard lock(camera_.mutex_);
  const TrueExposure& entry = camera_.faults_->history[sequence % SimulatedCamera::InjectedFaults::kHistory];
  if (sequence >= camera_.next_frame_ || entry.sequence != sequence) return std::nullopt;
  return entry;
}

void SimBench::drop_next(int frames) {
  const std::lock_guard lock(camera_.mutex_);
  camera_.faults_->drops = frames;
}

void SimBench::disturb_metadata(MetadataFault fault, int buffers) {
  const std::lock_guard lock(camera_.mutex_);
  camera_.faults_->metadata = fault, camera_.faults_->disturbed_buffers = buffers;
}

void SimBench::disturb_controls(ControlFault fault, int requests) {
  const std::lock_guard lock(camera_.mutex_);
  camera_.faults_->control = fault, camera_.faults_->disturbed_requests = requests;
}

void SimBench::unplug() {
  {
    const std::lock_guard lock(camera_.mutex_);
    camera_.faults_->unplugged = true;
  }
  camera_.changed_.notify_all();
}

}  // namespace hdrcam
