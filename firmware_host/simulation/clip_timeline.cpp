#include "firmware_host/simulation/clip_timeline.h"

#include <fmt/format.h>

#include <algorithm>

namespace hdrcam {

Result<ClipTimeline> ClipTimeline::create(const Simulation& simulation, std::vector<Exposure> cycle) {
  ClipTimeline timeline(simulation, std::move(cycle));
  const double longest_s = timeline.longest_exposure_s();
  if (from_seconds(longest_s) > simulation.frame_duration())  // both rounded: 1/60 s fits 60 fps
    return Error{
        ErrorCode::BadExposure,
        fmt::format("an exposure of {:.1f} ms does not fit a frame at {} fps; lower --shutter or fps",
                    longest_s * 1e3, simulation.framerate_hz)};
  for (const Exposure& exposure : timeline.cycle_)
    if (exposure.gain < 1)
      return Error{ErrorCode::BadExposure,
                   fmt::format("gain {:.4g}: a pixel of the simulated sensor is full before its code is the "
                               "largest; give gains of 1 and more",
                               exposure.gain)};
  return timeline;
}

Result<std::uint64_t> ClipTimeline::next_kept(std::uint64_t sequence) const {
  constexpr std::uint64_t kMostLost = 1'000'000;  // in a row
  const std::uint64_t end = sequence + kMostLost;
  while (stream_.loses(sequence))
    if (++sequence == end)
      return Error{ErrorCode::Invalid, fmt::format("drops={}: the scene loses {} frames in a row and nothing "
                                                   "arrives; give drops below 1, such as drops=0.1",
                                                   simulation_->drops.probability, kMostLost)};
  return sequence;
}

Shot ClipTimeline::shot(std::uint64_t sequence) const {
  const Exposure& exposure = cycle_[slot(sequence)];
  const double exposure_s = to_seconds(exposure.time), readout_s = to_seconds(simulation_->readout());
  return {sequence, centre_s(sequence) - (exposure_s + readout_s) / 2, exposure_s, exposure.gain};
}

FrameFacts ClipTimeline::facts(std::uint64_t sequence, bool after_drop, int bits) const {
  const Exposure& exposure = cycle_[slot(sequence)];
  FrameFacts facts;
  facts.sequence = sequence;
  facts.timestamp = Instant{stream_.host_time(from_seconds(centre_s(sequence))) + stream_.latency(sequence)};
  facts.exposure_s = to_seconds(exposure.time);
  facts.readout_s = to_seconds(simulation_->readout());
  facts.analogue_gain = exposure.gain;
  facts.slot = static_cast<int>(slot(sequence));
  if (simulation_->black_level > 0)
    facts.black_level = BlackLevel::of_code(
        static_cast<double>(simulation_->black_level * static_cast<float>((1 << bits) - 1)), bits);
  if (after_drop) facts.flags |= kFrameAfterDrop;
  return facts;
}

double ClipTimeline::longest_exposure_s() const {
  Duration longest{};
  for (const Exposure& exposure : cycle_) longest = std::max(longest, exposure.time);
  return to_seconds(longest);
}

}  // namespace hdrcam
