// hdrcam live --camera ID -o out/%06d.exr: turns a camera's frames into HDR frames as they arrive.
#include <cstdint>
#include <cstdio>
#include <memory>
#include <span>
#include <string>

#include "firmware_host/commands/camera_run.h"
#include "firmware_host/commands/recording_run.h"
#include "firmware_host/commands/with_settings.h"
#include "firmware_host/live/capture_setup.h"
#include "firmware_host/live/live_report.h"
#include "firmware_host/run/output_needs.h"
#include "firmware_host/run/run.h"
#include "firmware_host/sinks/frame_pattern.h"
#include "firmware_host/sinks/output_guard.h"
#include "firmware_host/sinks/sink_name.h"
#include "firmware_host/terminal.h"
#include "hal/core/counted.h"

namespace hdrcam {
namespace {

struct LiveFlags {
  RunLimits limits;
  bool strict = false;
  KeptWork kept;
  std::unique_ptr<SettingsFlags> settings;
};

std::string command_line_of(const LiveFlags& flags, const Settings& settings) {
  std::string text = "hdrcam live" + flags.settings->as_flags(settings);
  if (flags.limits.frames > 0) text += fmt::format(" --frames {}", flags.limits.frames);
  if (flags.limits.timeout_s > 0) text += fmt::format(" --timeout {}", flags.limits.timeout_s);
  if (flags.strict) text += " --strict";
  return text;
}

Result<void> check_strict(const LiveFlags& flags, const Settings::Camera& camera) {
  if (!flags.strict || is_read_as_fast_as_asked(camera)) return {};
  return Error{ErrorCode::Invalid,
               fmt::format("--strict is for a recording that is read at the fit's pace{}; leave it out",
                           is_replayed(camera.id) ? ", not with --pace realtime" : "")};
}

// Once the camera is open: of a run that is refused only the reason counts.
void tell_if_nothing_is_kept(const Settings& settings) {
  if (!writes_outputs(settings.output) && settings.record.file.empty())
    remark("note: this run writes no files; give -o out/%06d.exr, -o out.mp4 or --record walk.mkv\n");
}

std::string recorded_line(const Settings& settings, std::uint64_t recorded, std::uint64_t captured) {
  if (settings.record.file.empty() || recorded == 0) return "";  // no frame, no file
  return fmt::format("{}: {} of {}\n", settings.record.file, recorded, counted(captured, "frame"));
}

void warn_of_empty_outputs(const RunRecord& record, const Settings::Output& output) {
  for (const SinkTimes& sink : record.sinks)
    if (sink.frames == 0 && sink.left_out > 0)
      remark("warning: '{}' got no frame: {} left out to keep up\n", output.path(sink.name),
             sink.left_out == 1 ? "1 was" : fmt::format("{} were", sink.left_out));
}

// Then that is the reason, and not that the method needs more frames.
bool none_came_in_time(const Result<void>& ended, LiveEnd end, std::uint64_t captured) {
  return end == LiveEnd::Timeout && captured == 0 && !ended && ended.error().code == ErrorCode::TooShort;
}

// A recording in place of the camera, at the fit's pace: the same as `replay`, with the same bytes.
Result<void> replay_as_camera(const LiveFlags& flags, const Settings& settings, Surroundings& around) {
  const auto contradiction = flags.strict ? Contradiction::Fails : Contradiction::Warns;
  const auto source = TRY(open_replayed(settings, flags.limits, contradiction, around));
  TRY(admit_fit(settings, source->camera()));
  tell_if_nothing_is_kept(settings);
  Result<void> ended = run_on(
      *source,
      {.settings = settings, .title = source->camera().name, .command = command_line_of(flags, settings)},
      around.storage);
  const CaptureCounters counters = source->counters();
  if (counters.captured > 0 || ended.ok())
    write_result_beside_frames(
        settings.output, fmt::format("{}; {}\n{}", counted(counters.emitted, "frame"), proof_of(counters),
                                     recorded_line(settings, counters.emitted, counters.captured)));
  const LiveEnd end = source->timed_out() ? LiveEnd::Timeout : LiveEnd::Frames;
  return none_came_in_time(ended, end, counters.emitted) ? flags.limits.ended_by(end, counters.emitted)
                                                         : ended;
}

// The live page starts recordings later; whether their files can be made shows now.
Result<void> make_room_for_takes(const Settings::Output& output, Storage& storage) {
  if (output.http_takes.empty() || output.path(sink_name::kHttp).empty()) return {};
  const FramePattern names = TRY(FramePattern::parse("--http-record", output.http_takes, ".mkv"));
  const NamedOutput first{"--http-record", names.path(1), OutputKind::Recording};
  TRY(check_outputs(storage, {}, std::span(&first, 1), Overwrite::Force));  // a take never replaces a file
  return make_room_for(storage, std::span(&first, 1));
}

// Everything that can be refused before a camera is opened.
Result<void> check_live(const LiveFlags& flags, const Settings& settings, Surroundings& around) {
  TRY(check_strict(flags, settings.camera));
  TRY(check_needs(settings));
  TRY(check_no_terminal(settings.output.paths));
  if (is_replayed(settings.camera.id))
    TRY(check_recorded_poses(replayed_file(settings.camera.id), settings, around));
  else
    TRY(check_tracked_poses(settings, "a camera states none"));
  TRY(check_camera_run(settings, "--record", sink_kinds(), flags.kept, around.storage));
  return is_read_as_fast_as_asked(settings.camera) ? Result<void>()
                                                   : make_room_for_takes(settings.output, around.storage);
}

// What became of the frames, and what to do where some were lost on their way.
void tell_of_run(CameraSource& camera, const Settings& settings, const RunRecord& record) {
  const LiveCounters counters = camera.session().counters();
  if (counters.captured() > 0)
    write_result_beside_frames(
        settings.output,
        account_of(camera) +
            recorded_line(settings, counters.recorded - counters.in_takes, counters.captured()) +
            camera.takes_account());
  show_warnings(camera, settings);
  if (const std::string advice = advice_to_keep_up(counters, settings, record); !advice.empty())
    remark("note: {}\n", advice);
  warn_of_empty_outputs(record, settings.output);
}

// That a user stops a run before its first HDR frame is no failure of it.
bool is_stopped_at_once(CameraSource& camera, const Result<void>& ended) {
  return camera.end() == LiveEnd::Stopped && camera.session().counters().emitted == 0 && !ended &&
         ended.error().code == ErrorCode::TooShort;
}

Result<void> live(const LiveFlags& flags, const Settings& asked, Surroundings& around) {
  const Settings settings = TRY(started_settings(*flags.settings, asked));
  TRY(check_live(flags, settings, around));
  if (is_read_as_fast_as_asked(settings.camera)) return replay_as_camera(flags, settings, around);
  TraceFile trace(settings);
  const auto camera = TRY(open_camera_source(settings, flags.limits.options(LiveWork::Fit), trace, around));
  tell_if_nothing_is_kept(settings);
  RunRecord record;
  RunPlan plan{.settings = settings,
               .title = camera->camera().name,
               .command = command_line_of(flags, settings),
               .trace = trace.trace(),
               .record = &record};
  if (Supervisor::of_environment().present()) plan.progress = nullptr;  // the service's status has the line
  const Result<void> ended = trace.write_after(run(plan, *camera, around.storage), around.storage);
  tell_of_run(*camera, settings, record);
  const std::uint64_t captured = camera->session().counters().captured();
  if (is_stopped_at_once(*camera, ended))
    remark("note: stopped before the first HDR frame\n");
  else if (!none_came_in_time(ended, camera->end(), captured))
    TRY(ended);
  return flags.limits.ended_by(camera->end(), captured);
}

}  // namespace

void add_live(CommandLine program, Verb& chosen) {
  auto flags = std::make_shared<LiveFlags>();
  CommandLine verb = program.add_verb("live", "turn a camera's frames into HDR frames as they arrive");
  flags->limits.add_to(verb);
  verb.add_switch(
      "--strict", flags->strict,
      "fail where the pictures of replay:FILE contradict an exposure, instead of relabelling or flagging it");
  flags->kept.add_to(verb);
  flags->settings = std::make_unique<SettingsFlags>(
      verb, std::vector<SettingGroup>{SettingGroup::Camera, SettingGroup::Schedule, SettingGroup::Sync,
                                      SettingGroup::Fit, SettingGroup::Knobs, SettingGroup::Output,
                                      SettingGroup::Record, SettingGroup::Machine});
  verb.on_chosen([flags, &chosen] { chosen = with_settings(flags, live); });
}

}  // namespace hdrcam
