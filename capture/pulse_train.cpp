#include "capture/pulse_train.h"

#include <algorithm>

namespace hdrcam {

Duration PulseTrain::longest_width(const TriggerOptions& options) {
  return options.interval - options.gap - options.tolerance;
}

Result<void> PulseTrain::check(const TriggerOptions& options, const ExposureSchedule& schedule,
                               const CameraCapabilities& camera) {
  const bool exposes = options.mode == TriggerMode::PulseWidth;
  const Duration longest = longest_width(options);
  if (longest <= Duration(0))
    return Error{
        ErrorCode::BadExposure,
        fmt::format("a gap of {} between trigger pulses and edges up to {} late do not fit a frame of {}; "
                    "lower --trigger-gap, --trigger-tolerance or --framerate",
                    describe(options.gap), describe(options.tolerance), describe(options.interval))};
  const ExposureSchedule::Cycle cycle = schedule.cycle();
  for (const Exposure& exposure : cycle) {
    if (exposes && exposure.gain != cycle.front().gain)
      return Error{
          ErrorCode::Invalid,
          fmt::format("gains {} and {} differ; with --trigger pulse-width all exposures have one gain, "
                      "because nothing ties a gain to a pulse: give one to --gain",
                      cycle.front().gain, exposure.gain)};
    const Duration width = exposes ? exposure.time : options.width;
    if (width > longest)
      return Error{
          ErrorCode::BadExposure,
          fmt::format("a trigger pulse of {} does not fit a frame of {} with a gap of {} and edges up to {} "
                      "late; shorten it to {} ({}), or lower --framerate, --trigger-gap or "
                      "--trigger-tolerance",
                      describe(width), describe(options.interval), describe(options.gap),
                      describe(options.tolerance),
                      describe(rounded_down(exposes ? longest_within(longest, camera) : longest)),
                      exposes ? "--shutter" : "--trigger-width")};
  }
  return {};
}

void PulseTrain::start(Instant first) {
  first_ = not_before_ = first;
  next_ = driven_ = 0;
}

PlannedPulse PulseTrain::next(Instant now) {
  for (;;) {
    PlannedPulse pulse;
    pulse.number = next_++;
    pulse.slot = schedule_.slot_of(pulse.number);
    pulse.begin = first_ + options_.interval * static_cast<Duration::rep>(pulse.number);
    pulse.width =
        options_.mode == TriggerMode::PulseWidth ? schedule_.slot(pulse.slot).exposure.time : options_.width;
    pulse.not_before = std::max(pulse.begin, not_before_);
    const Instant begins = std::max(pulse.not_before, now);
    const Instant successor = pulse.begin + options_.interval;
    if (begins == pulse.begin || begins + pulse.width + options_.gap <= successor) return pulse;
  }
}

TriggerPulse PulseTrain::driven(const PlannedPulse& planned, const DrivenEdge& rise, const DrivenEdge& fall) {
  TriggerPulse pulse{.planned = planned, .index = driven_++, .rise = rise, .fall = fall};
  pulse.late = pulse.begin_error() > options_.tolerance || pulse.width_error() > options_.tolerance;
  not_before_ = fall.at + options_.gap;
  return pulse;
}

}  // namespace hdrcam
