#include "capture/exposure_schedule.h"

#include <algorithm>
#include <cmath>

namespace hdrcam {
namespace {

// The multiple of `period`, at least one, that is nearest to `time` and no longer than `longest`.
Duration nearest_multiple(Duration time, Duration period, Duration longest) {
  const auto multiples = std::max<Duration::rep>(1, (time + period / 2) / period);
  return std::min(multiples, std::max<Duration::rep>(1, longest / period)) * period;
}

}  // namespace

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

// Sensors need between 4 and 48 lines (IMX708) beyond the exposure. Where the step of the control is no line
// but a coarse unit (UVC counts in 100 us), 48 of them would be far too much.
Duration ExposureSchedule::frame_margin(const CameraCapabilities& camera) {
  constexpr Duration kMost{1'000'000};
  return std::min(48 * camera.exposure_step, kMost);
}

Result<ExposureSchedule> ExposureSchedule::create(std::span<const Exposure> cycle,
                                                  const CameraCapabilities& camera, Duration frame_duration,
                                                  Mains mains) {
  if (cycle.empty() || cycle.size() > kMaxSlots)
    return Error{ErrorCode::Invalid, fmt::format("a cycle has 1 to {} exposures, not {}; see --shutter",
                                                 int{kMaxSlots}, cycle.size())};
  const Duration margin = frame_margin(camera);
  const Duration half = half_period(mains);

  ExposureSchedule schedule;
  for (const Exposure& asked : cycle) {
    if (asked.time + margin > frame_duration) {
      const double fastest_hz = 1 / to_seconds(asked.time + margin);
      return Error{
          ErrorCode::BadExposure,
          fmt::format("shutter {} does not fit a frame of {} with {} of read-out; shorten it to {}, or lower "
                      "--framerate to {:.2f}",
                      describe(asked.time), describe(frame_duration), describe(margin),
                      describe(std::max(Duration(0), frame_duration - margin)),
                      std::floor(fastest_hz * 100) / 100)};
    }
    Slot slot{asked, asked, false};
    if (half > Duration(0)) {
      const Duration longest = std::min(frame_duration - margin, camera.exposure_max);
      slot.flickers = asked.time < half || longest < half;
      if (!slot.flickers) slot.exposure.time = nearest_multiple(asked.time, half, longest);
    }
    slot.exposure = TRY(quantised(slot.exposure, camera));
    schedule.shortest_frame_duration_ =
        std::max(schedule.shortest_frame_duration_, slot.exposure.time + margin);
    schedule.slots_[static_cast<std::size_t>(schedule.count_++)] = slot;
  }
  return schedule;
}

double ExposureSchedule::reference_exposure() const {
  double sum = 0;
  for (int i = 0; i < count_; ++i) sum += log_product(slot(i).exposure);
  return std::exp(sum / count_);
}

}  // namespace hdrcam
