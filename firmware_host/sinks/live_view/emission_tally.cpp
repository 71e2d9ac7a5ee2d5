#include "firmware_host/sinks/live_view/emission_tally.h"

#include <algorithm>
#include <cmath>

#include "capture/exposure.h"

namespace hdrcam {
namespace {

// Relative exposures; so small a share of one is its difference in ln.
bool same(double a, double b) { return std::abs(a - b) <= kSameInList * std::max(a, b); }

}  // namespace

void EmissionTally::count(const EmittedFrame& frame) {
  const FrameFacts& facts = frame.hdr.facts;
  const std::lock_guard lock(mutex_);
  const std::size_t place = sums_.frames % kRecent;
  sums_.newest = times_[place] = Clock::now();
  exposures_[place] = {facts.exposure_s, facts.gain(), static_cast<double>(frame.hdr.exposure)};
  ++sums_.frames;
  sums_.latency_ms = frame.record.latency_ms;
  sums_.processing_ms += frame.record.total_ms;
  for (const NamedValue& stage : frame.record.stages_ms) add_to(sums_.stages_ms, stage);
  if (facts.verdict) ++sums_.verdicts[static_cast<std::size_t>(*facts.verdict)];
}

EmissionFigures EmissionTally::figures() const {
  const std::lock_guard lock(mutex_);
  EmissionFigures figures = sums_;
  const std::size_t held = std::min<std::size_t>(sums_.frames, kRecent);
  for (std::size_t i = 0; i < held; ++i) {
    const ExposureInUse& exposure = exposures_[i];
    const bool known = std::ranges::any_of(
        figures.exposures, [&](const auto& other) { return same(other.relative, exposure.relative); });
    if (!known) figures.exposures.push_back(exposure);
  }
  std::ranges::sort(figures.exposures, {}, &ExposureInUse::relative);
  if (held >= 2) {
    const auto oldest = times_[held < kRecent ? 0 : sums_.frames % kRecent];
    // Up to now, where the next frame is overdue: a stream that stopped slows down.
    const std::chrono::duration<double> span = sums_.newest - oldest, silence = Clock::now() - sums_.newest;
    const double frame_s = span.count() / static_cast<double>(held - 1);
    const double all_s = span.count() + std::max(0.0, silence.count() - frame_s);
    figures.per_second = all_s > 0 ? static_cast<double>(held - 1) / all_s : 0;
  }
  return figures;
}

}  // namespace hdrcam
