#include "firmware_host/commands/ignored_flags.h"

#include <fmt/ranges.h>

#include "firmware_host/live/capture_setup.h"

namespace hdrcam {
namespace {

// A recording has its size, its rate and its exposures.
Result<void> check_recorded_camera(const SettingsFlags& flags, const Settings::Camera& camera) {
  if (!is_replayed(camera.id)) return {};
  const std::vector<std::string> ignored =
      flags.given({"camera.format", "camera.width", "camera.height", "camera.framerate", "schedule.shutter",
                   "schedule.gain", "schedule.adapt", "schedule.mains"});
  if (ignored.empty()) return {};
  return Error{ErrorCode::Invalid,
               fmt::format("the pictures and exposures of '{}' are recorded and cannot be set; leave out {}",
                           camera.id, fmt::join(ignored, ", "))};
}

Result<void> check_live_page(const SettingsFlags& flags, const Settings::Output& output) {
  if (!output.path("http").empty()) return {};
  const std::vector<std::string> ignored = flags.given({"output.http_token", "output.http_record"});
  if (ignored.empty()) return {};
  return Error{ErrorCode::Invalid,
               fmt::format("there is no live page for {}; give --http 127.0.0.1:8080 too, or leave it out",
                           fmt::join(ignored, " and "))};
}

}  // namespace

Result<void> check_ignored_flags(const SettingsFlags& flags, const Settings& settings) {
  TRY(check_recorded_camera(flags, settings.camera));
  return check_live_page(flags, settings.output);
}

}  // namespace hdrcam
