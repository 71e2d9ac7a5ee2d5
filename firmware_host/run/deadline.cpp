#include "firmware_host/run/deadline.h"

#include "capture/exposure.h"

namespace hdrcam {

std::optional<Duration> deadline_of(const Settings::Fit& fit, const CameraFacts& camera, RunPace pace) {
  if (fit.deadline == kOff) return std::nullopt;
  if (!fit.deadline.empty()) return parse_duration(fit.deadline).value();
  if (pace == RunPace::Clip || !(camera.framerate_hz > 0)) return std::nullopt;
  return from_seconds(1 / camera.framerate_hz);
}

bool is_pace_of(const CameraFacts& camera, Duration deadline) {
  constexpr double kAlmost = 0.999;  // of the interval, which is rounded
  return to_seconds(deadline) * camera.framerate_hz >= kAlmost;
}

}  // namespace hdrcam
