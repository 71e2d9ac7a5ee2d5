// hdrcam record --camera ID -o walk.mkv: records every frame of a camera, raw, with the verdict on its
// exposure.
#include <cstdio>
#include <memory>

#include "capture/recorded_labels.h"
#include "firmware_host/commands/camera_run.h"
#include "firmware_host/commands/recording_run.h"
#include "firmware_host/commands/with_settings.h"
#include "firmware_host/live/live_report.h"
#include "firmware_host/run/memory_need.h"
#include "firmware_host/terminal.h"
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
  const auto source = TRY(open_replayed(settings, flags.limits, Contradiction::Warns, around));
  TRY(admit_copy(settings, source->camera(),
                 {.waiting = RecordedLabels::kBeginning, .codec = settings.record.codec}));
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
  if (counters.captured > 0 || (failed.ok() && ended.ok()))
    say("{}; {}\n", counted(counters.emitted, "frame"), proof_of(counters));
  if (counters.emitted > 0) say("{}\n", settings.record.file);
  TRY(failed);
  TRY(ended);
  return source->timed_out() ? flags.limits.ended_by(LiveEnd::Timeout, counters.emitted) : Result<void>();
}

Result<void> record_frames(const RecordFlags& flags, const Settings& asked, Surroundings& around) {
  if (asked.record.file.empty())
    return Error{ErrorCode::Invalid, "no output file; give -o FILE, or set record.file"};
  const Settings settings = TRY(started_settings(*flags.settings, asked));
  TRY(check_camera_run(settings, "--output", {}, flags.kept, around.storage));
  TraceFile trace(settings);
  if (is_read_as_fast_as_asked(settings.camera))
    return trace.write_after(record_again(flags, settings, trace.trace(), around), around.storage);
  const auto camera =
      TRY(open_camera_source(settings, flags.limits.options(LiveWork::RecordOnly), trace, around));
  LiveSession& session = camera->session();
  TRY(camera->start());
  {
    LiveStatus status(session, LiveWork::RecordOnly);
    const bool supervised = Supervisor::of_environment().present();  // then the service's status has the line
    session.next([&] { supervised ? void() : status.update(); });
  }
  RunRecord record;
  const Result<void> ended = trace.write_after(camera->finish(record), around.storage);
  const LiveCounters counters = session.counters();
  write_result(account_of(*camera));
  show_warnings(*camera, settings);
  if (counters.recorded > 0) say("{}\n", settings.record.file);
  TRY(ended);
  return flags.limits.ended_by(camera->end(), counters.captured());
}

}  // namespace

void add_record(CommandLine program, Verb& chosen) {
  auto flags = std::make_shared<RecordFlags>();
  CommandLine verb = program.add_verb(
      "record", "record a camera's raw frames, each with its exposure and the verdict on it");
  flags->limits.add_to(verb);
  flags->kept.add_to(verb);
  flags->settings = std::make_unique<SettingsFlags>(verb, kGroups);
  verb.on_chosen([flags, &chosen] { chosen = with_settings(flags, record_frames); });
}

}  // namespace hdrcam
