// hdrcam record --camera ID -o walk.mkv: records every frame of a camera, raw, with the verdict on its
// exposure.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "firmware_host/commands/camera_run.h"
#include "firmware_host/commands/command.h"
#include "firmware_host/commands/ignored_flags.h"
#include "firmware_host/commands/kept_work.h"
#include "firmware_host/commands/recording_run.h"
#include "firmware_host/commands/run_limits.h"
#include "firmware_host/commands/trace_file.h"
#include "firmware_host/live/camera_source.h"
#include "firmware_host/live/capture_setup.h"
#include "firmware_host/live/live_report.h"
#include "firmware_host/settings/settings_flags.h"
#include "firmware_host/settings/start_time.h"
#include "firmware_host/terminal.h"
#include "hal/clock.h"
#include "hal/core/counted.h"

namespace hdrcam {
namespace {

struct RecordFlags {
  RunLimits limits;
  KeptWork kept;
  std::unique_ptr<SettingsFlags> settings;
};

const std::vector<SettingGroup> kGroups{SettingGroup::Camera, SettingGroup::Schedule, SettingGroup::Sync,
                                        SettingGroup::Record, SettingGroup::Machine};

// A recording in place of the camera: every frame once more, with what is known of the camera, as fast as the
// disk takes them.
Result<void> record_again(const RecordFlags& flags, const Settings& settings, Trace* trace,
                          Surroundings& around) {
  const auto source = TRY(RecordingSource::open(around.storage, replayed_file(settings.camera.id),
                                                recording_options(settings, flags.limits), around.stop));
  Result<void> failed;
  for (;;) {
    const TraceSpan span(trace, "record");
    const auto frame = source->next();
    if (!frame) failed = frame.error();
    if (!frame || frame.value() == nullptr) break;
  }
  RunRecord record;
  Result<void> ended = source->finish(record);
  show_warnings(*source);
  const CaptureCounters counters = source->counters();
  say("{}; {}\n", counted(counters.emitted, "frame"), proof_of(counters));
  if (counters.emitted > 0) say("{}\n", settings.record.file);
  TRY(failed);
  return ended;
}

Result<void> record_frames(const RecordFlags& flags, Surroundings& around) {
  Settings settings = TRY(flags.settings->read(around.storage));
  if (flags.settings->print_config()) return say("{}", flags.settings->printed(settings)), Result<void>{};
  TRY(check_ignored_flags(*flags.settings, settings));
  settings = with_start_time(std::move(settings), posix_clock().wall_time());
  if (settings.record.file.empty())
    return Error{ErrorCode::Invalid, "no output file; give -o FILE, or set record.file"};
  TRY(check_camera_run(settings, "--output", flags.kept, around.storage));
  TraceFile trace(settings);
  if (is_read_as_fast_as_asked(settings.camera))
    return trace.write_after(record_again(flags, settings, trace.trace(), around), around.storage);
  LiveOptions limits = flags.limits.options(false);
  limits.trace = trace.trace();
  const auto camera = TRY(CameraSource::open(settings, limits, around.storage, around.stop));
  LiveSession& session = camera->session();
  for (const std::string& warning : camera->warnings()) remark("note: {}\n", warning);

  TRY(camera->start());
  {
    LiveStatus status(session, false);
    const bool supervised = Supervisor::of_environment().present();  // then the service's status has the line
    session.next(around.stop, [&] { supervised ? void() : status.update(); });
  }
  RunRecord record;
  const Result<void> ended = trace.write_after(camera->finish(record), around.storage);
  const LiveCounters counters = session.counters();
  say("{}\n{}\n", sentence_of(counters, false), proof_of(counters.camera));
  if (const std::string account = camera->trigger_account(); !account.empty()) say("{}\n", account);
  if (counters.recorded > 0) say("{}\n", settings.record.file);
  TRY(ended);
  return flags.limits.ended_by(camera->end(), counters.captured());
}

}  // namespace

void add_record(CLI::App& app, Verb& chosen) {
  auto flags = std::make_shared<RecordFlags>();
  CLI::App* verb =
      app.add_subcommand("record", "record a camera's frames, raw, each with its proved exposure");
  flags->limits.add_to(*verb);
  flags->kept.add_to(*verb);
  flags->settings = std::make_unique<SettingsFlags>(*verb, kGroups);
  verb->callback(
      [flags, &chosen] { chosen = [flags](Surroundings& around) { return record_frames(*flags, around); }; });
}

}  // namespace hdrcam
