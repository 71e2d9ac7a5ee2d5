#include "firmware_host/commands/camera_run.h"

#include "capture/exposure.h"
#include "firmware_host/commands/recording_name.h"
#include "firmware_host/live/capture_setup.h"
#include "firmware_host/live/trigger_setup.h"

namespace hdrcam {

Result<void> check_camera_run(const Settings& settings, const char* recording_flag, const KeptWork& kept,
                              Storage& storage) {
  TRY(check_recording_name(storage, recording_flag, settings.record.file));
  TRY(parse_exposures(settings.schedule.shutter, settings.schedule.gain));  // before a folder is made
  TRY(kept.check(storage, inputs_of(settings.camera), outputs_of(settings, recording_flag)));
  return check_lines(settings);
}

bool is_read_as_fast_as_asked(const Settings::Camera& camera) {
  return is_replayed(camera.id) && camera.pace == ReplayPace::AsFastAsAsked;
}

RecordingSourceOptions recording_options(const Settings& settings, const RunLimits& limits) {
  RecordingSourceOptions options{.frames = static_cast<int>(limits.frames),
                                 .timeout = from_seconds(limits.timeout_s),
                                 .copy_to = settings.record.file,
                                 .copy_codec = settings.record.codec};
  if (settings.camera.black_level >= 0) options.black_level = BlackLevel(settings.camera.black_level);
  return options;
}

}  // namespace hdrcam
