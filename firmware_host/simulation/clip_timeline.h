// When each frame of a simulated clip is exposed, for how long, and what the recording says of it. Frames are
// counted at the sensor, lost ones among them; the exposures of the cycle follow each other without a gap.
// The middle of picture and exposure of frame n is n frame durations after the scene's beginning, so that
// frames of different exposures are evenly spaced. Thread-bound.
#pragma once

#include <cstdint>
#include <vector>

#include "capture/exposure.h"
#include "hal/sim/simulated_sensor.h"
#include "hal/sim/stream_effects.h"

namespace hdrcam {

class ClipTimeline {
 public:
  // The simulation outlives it. Errors: BadExposure for a cycle with an exposure that is longer than a frame,
  // or with a gain below 1, the simulated camera's least.
  static Result<ClipTimeline> create(const Simulation& simulation, std::vector<Exposure> cycle);

  // The first frame from this one on that is not lost. Errors: Invalid for a scene that loses them all.
  Result<std::uint64_t> next_kept(std::uint64_t sequence) const;
  // Scene time of the middle of picture and exposure.
  double centre_s(std::uint64_t sequence) const {
    return static_cast<double>(sequence) / simulation_->framerate_hz;
  }
  Shot shot(std::uint64_t sequence) const;
  // bits: of a code.
  FrameFacts facts(std::uint64_t sequence, bool after_drop, int bits) const;
  // Of the cycle.
  double longest_exposure_s() const;

 private:
  ClipTimeline(const Simulation& simulation, std::vector<Exposure> cycle)
      : simulation_(&simulation), cycle_(std::move(cycle)), stream_(simulation) {}
  std::size_t slot(std::uint64_t sequence) const { return sequence % cycle_.size(); }

  const Simulation* simulation_;
  std::vector<Exposure> cycle_;
  StreamEffects stream_;
};

}  // namespace hdrcam
