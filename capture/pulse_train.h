// When each trigger pulse is due and how wide it is: one for every frame interval, on a grid that does not
// drift, with the exposures of the schedule in turn. What was driven is compared with what was planned. Value
// type, thread-bound.
#pragma once

#include <cstddef>
#include <cstdint>

#include "capture/exposure_schedule.h"
#include "hal/trigger_line.h"

namespace hdrcam {

struct TriggerOptions {
  TriggerMode mode = TriggerMode::FrameStart;
  Duration interval = kUsualFrameDuration;  // between leading edges
  Duration width{200'000};                  // of a pulse that only starts a frame
  Duration gap{1'000'000};      // the line is inactive at least this long between pulses (read-out)
  Duration tolerance{500'000};  // an edge later than this is late
};

struct PlannedPulse {
  std::uint64_t number = 0;  // intervals since the first pulse
  int slot = 0;              // of the schedule
  Instant begin;
  Duration width{0};
  Instant not_before;  // where the pulse before it ended late
};

// A pulse that was driven.
struct TriggerPulse {
  PlannedPulse planned;
  std::uint64_t index = 0;  // pulses before it; smaller than the number where some were left out
  DrivenEdge rise, fall;
  bool late = false;  // an edge was later than the tolerance

  Duration width() const { return fall.at - rise.at; }
  Duration width_within() const { return rise.within + fall.within; }
  // Later than planned: of the leading edge its instant, of the trailing edge the width.
  Duration begin_error() const { return rise.at - planned.begin; }
  Duration width_error() const { return width() - planned.width; }
};

// Driven pulses that wait at most for a capture thread that is late.
inline constexpr std::size_t kMostWaitingPulses = 1024;

class PulseTrain {
 public:
  // The widest pulse of a train: its edges may be late by the tolerance, and the next one is in time.
  static Duration longest_width(const TriggerOptions& options);
  // Errors: BadExposure for a pulse wider than that, naming the widest that the camera's exposure times
  // allow; Invalid for exposures of different gain in PulseWidth (a gain is set by requests, and nothing ties
  // a request to a pulse).
  static Result<void> check(const TriggerOptions& options, const ExposureSchedule& schedule,
                            const CameraCapabilities& camera = {});

  // The schedule passes check().
  PulseTrain(const TriggerOptions& options, const ExposureSchedule& schedule)
      : options_(options), schedule_(schedule) {}

  void start(Instant first);
  void follow(const ExposureSchedule& schedule) { schedule_ = schedule; }

  // The next pulse. One that could end only within the gap before its successor is left out.
  PlannedPulse next(Instant now);
  TriggerPulse driven(const PlannedPulse& planned, const DrivenEdge& rise, const DrivenEdge& fall);

 private:
  TriggerOptions options_;
  ExposureSchedule schedule_;
  Instant first_, not_before_;
  std::uint64_t next_ = 0, driven_ = 0;
};

}  // namespace hdrcam
