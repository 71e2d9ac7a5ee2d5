#include "capture/exposure_schedule.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace hdrcam {
namespace {

// An exposure too long for its frame, and what would do: only times and rates that are accepted.
Error does_not_fit(const Exposure& asked, const CameraCapabilities& camera, Duration frame_duration,
                   Duration margin) {
  constexpr double kLeastFramerate_hz = 0.1;  // of --framerate
  const Duration longest = rounded_down(std::min(frame_duration - margin, camera.exposure_max));
  const double fastest_hz = std::floor(100 / to_seconds(asked.time + margin)) / 100;
  std::vector<std::string> ways;
  if (longest > Duration(0) && longest >= camera.exposure_min)
    ways.push_back(fmt::format("shorten it to {}", describe(longest)));
  if (asked.time <= camera.exposure_max && fastest_hz >= kLeastFramerate_hz)
    ways.push_back(fmt::format("lower --framerate to {:.2f}", fastest_hz));
  return {ErrorCode::BadExposure,
          fmt::format("shutter {} does not fit a frame of {} with {} of read-out; {}", describe(asked.time),
                      describe(frame_duration), describe(margin),
                      ways.empty() ? "lower --framerate" : fmt::format("{}", fmt::join(ways, ", or ")))};
}

}  // namespace

Duration rounded_down(Duration longest) {
  Duration::rep unit = 1;
  while (longest.count() / unit >= 10'000) unit *= 10;  // describe() prints four digits
  return Duration(longest.count() / unit * unit);
}

Result<void> check_slots(std::span<const Exposure> cycle) {
  if (!cycle.empty() && cycle.size() <= ExposureSchedule::kMaxSlots) return {};
  return Error{ErrorCode::Invalid, fmt::format("a cycle has 1 to {} exposures, not {}; see --shutter",
                                               int{ExposureSchedule::kMaxSlots}, cycle.size())};
}

Result<void> check_distinct(std::span<const Exposure> cycle) {
  if (cycle.size() < 2 || !all_same(cycle)) return {};
  return Error{
      ErrorCode::Invalid,
      fmt::format("{} exposures of the cycle are the same, {}; give different ones to --shutter or "
                  "--gain, or a single one",
                  cycle.size() == 2 ? "both" : fmt::format("all {}", cycle.size()), describe(cycle.front()))};
}

Duration half_period(Mains mains) {
  switch (mains) {
    case Mains::Hz50:
      return Duration(10'000'000);
    case Mains::Hz60:
      return Duration(8'333'333);
    case Mains::Off:
      break;
  }
  return Duration(0);
}

bool lasts(Duration exposure, Duration half_period) {
  constexpr double kRounding = 0.995;
  return to_seconds(exposure) >= kRounding * to_seconds(half_period);
}

Duration whole_half_periods(Duration time, Duration half_period, Duration longest) {
  const auto nearest = std::max<Duration::rep>(1, (time + half_period / 2) / half_period);
  return std::min(nearest, std::max<Duration::rep>(1, longest / half_period)) * half_period;
}

// Sensors need between 4 and 48 lines (IMX708) beyond the exposure. Where a step of the control is not a line
// but a coarse unit (UVC counts in 100 us), 48 steps would be far too much.
Duration ExposureSchedule::frame_margin(const CameraCapabilities& camera) {
  constexpr Duration kMost{1'000'000};
  return std::min(std::chrono::round<Duration>(48 * camera.exposure_step), kMost);
}

Result<ExposureSchedule> ExposureSchedule::create(std::span<const Exposure> cycle,
                                                  const CameraCapabilities& camera, Duration frame_duration,
                                                  Mains mains) {
  TRY(check_slots(cycle));
  const Duration margin = frame_margin(camera);
  const Duration half = half_period(mains);

  ExposureSchedule schedule;
  std::vector<Exposure> exposures;  // rounded to what the sensor can do
  for (const Exposure& asked : cycle) {
    if (asked.time + margin > frame_duration) return does_not_fit(asked, camera, frame_duration, margin);
    Slot slot{asked, asked, false};
    if (half > Duration(0)) {
      const Duration longest = std::min(frame_duration - margin, camera.exposure_max);
      slot.flickers = !lasts(asked.time, half) || longest < half;
      if (!slot.flickers) slot.exposure.time = whole_half_periods(asked.time, half, longest);
    }
    slot.exposure = TRY(quantised(slot.exposure, camera));
    exposures.push_back(slot.exposure);
    schedule.slots_.push_back(slot);
  }
  TRY(check_distinct(exposures));
  return schedule;
}

Result<ExposureSchedule> ExposureSchedule::observed(std::span<const Exposure> cycle) {
  TRY(check_slots(cycle));
  ExposureSchedule schedule;
  for (const Exposure& exposure : cycle) schedule.slots_.push_back({exposure, exposure, false});
  return schedule;
}

ExposureSchedule::Cycle ExposureSchedule::cycle() const {
  Cycle exposures;
  for (const Slot& slot : slots_) exposures.push_back(slot.exposure);
  return exposures;
}

int ExposureSchedule::nearest_slot(const Exposure& exposure) const {
  const auto distance = [&](int i) {
    return std::abs(log_product(slot(i).exposure) - log_product(exposure));
  };
  int nearest = 0, equals = 0;
  for (int i = 1; i < slots(); ++i)
    if (distance(i) < distance(nearest)) nearest = i;
  for (int i = 0; i < slots(); ++i) equals += distance(i) == distance(nearest) ? 1 : 0;
  return equals == 1 ? nearest : -1;
}

}  // namespace hdrcam
