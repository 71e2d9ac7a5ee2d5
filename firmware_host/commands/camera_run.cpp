#include "firmware_host/commands/camera_run.h"

#include <vector>

#include "capture/exposure.h"
#include "firmware_host/commands/ignored_flags.h"
#include "firmware_host/commands/no_snapshot.h"
#include "firmware_host/commands/recording_name.h"
#include "firmware_host/commands/run_files.h"
#include "firmware_host/live/capture_setup.h"
#include "firmware_host/live/live_report.h"
#include "firmware_host/live/trigger_setup.h"
#include "firmware_host/settings/start_time.h"
#include "firmware_host/terminal.h"
#include "hal/clock.h"

namespace hdrcam {

Result<Settings> started_settings(const SettingsFlags& flags, const Settings& asked) {
  TRY(check_ignored_flags(flags, asked));
  return with_start_time(asked, posix_clock().wall_time());
}

Result<void> check_replayed(const Settings::Camera& camera, Storage& storage) {
  if (!is_replayed(camera.id)) return {};
  const std::string file = replayed_file(camera.id);
  if (file.empty())
    return Error{ErrorCode::Invalid, "'replay:' names no recording; write --camera replay:walk.mkv"};
  return check_no_snapshot(storage, file);
}

Result<void> check_camera_run(const Settings& settings, const char* recording_flag,
                              std::span<const SinkKind> sinks, const KeptWork& kept, Storage& storage) {
  TRY(check_recording_name(storage, recording_flag, settings.record.file));
  TRY(check_replayed(settings.camera, storage));  // as the next, before a folder is made
  TRY(parse_exposures(settings.schedule.shutter, settings.schedule.gain));
  if (!settings.camera.control_delay.empty()) TRY(parse_delays(settings.camera.control_delay));
  TRY(check_lines(settings));
  std::vector<NamedOutput> outputs = outputs_of(settings, sinks);
  outputs.push_back({recording_flag, settings.record.file, OutputKind::Recording});
  return kept.check(storage, inputs_of(settings.camera), outputs);
}

Result<std::unique_ptr<CameraSource>> open_camera_source(const Settings& settings, LiveOptions limits,
                                                         TraceFile& trace, Surroundings& around) {
  limits.trace = trace.trace();
  auto camera = TRY(CameraSource::open(settings, limits, around.storage, around.stop));
  for (const std::string& warning : camera->warnings()) remark("note: {}\n", warning);
  return camera;
}

std::string account_of(CameraSource& camera) {
  const LiveCounters counters = camera.session().counters();
  std::string text = fmt::format("{}\n{}\n", sentence_of(counters, camera.work()), proof_of(counters.camera));
  if (counters.emitted > 0)
    text += fmt::format("latency: {:.0f} ms at most\n", to_seconds(counters.longest_latency) * 1e3);
  for (const std::string& account : camera.accounts()) text += account + "\n";
  return text;
}

void show_warnings(CameraSource& camera, const Settings& settings) {
  for (const std::string& warning : camera.camera_warnings()) remark("warning: {}\n", warning);
  const std::string advice = advice_on_light(camera.session().counters(), settings);
  if (!advice.empty()) remark("note: {}\n", advice);
}

bool is_read_as_fast_as_asked(const Settings::Camera& camera) {
  return is_replayed(camera.id) && camera.pace == ReplayPace::AsFastAsAsked;
}

Result<std::unique_ptr<RecordingSource>> open_replayed(const Settings& settings, const RunLimits& limits,
                                                       Contradiction contradiction, Surroundings& around) {
  RecordingSourceOptions options{.frames = static_cast<int>(limits.frames),
                                 .timeout = from_seconds(limits.timeout_s),
                                 .contradiction = contradiction,
                                 .copy_to = settings.record.file,
                                 .copy_codec = settings.record.codec};
  if (settings.camera.black_level >= 0) options.black_level = BlackLevel(settings.camera.black_level);
  return RecordingSource::open(around.storage, replayed_file(settings.camera.id), options, around.stop);
}

}  // namespace hdrcam
