#include "firmware_host/commands/ignored_flags.h"

#include <fmt/ranges.h>

#include "firmware_host/commands/camera_run.h"
#include "firmware_host/live/capture_setup.h"
#include "firmware_host/settings/setting_fields.h"
#include "firmware_host/sinks/sink_name.h"
#include "hal/video/video_writer.h"

namespace hdrcam {
namespace {

// Refuses those of these settings that the command line set. why: a sentence, such as "the scene of 'x' is
// fitted already"; joint: stands between it and the advice to leave them out.
Result<void> refuse_given(const SettingsFlags& flags, const std::vector<std::string>& keys,
                          std::string_view why, std::string_view joint = ";") {
  const std::vector<std::string> ignored = flags.given(keys);
  if (ignored.empty()) return {};
  return Error{ErrorCode::Invalid, fmt::format("{}{} leave out {}", why, joint, fmt::join(ignored, ", "))};
}

// The same unless the run uses them. why: with what to give, such as "this run writes no video; give -o
// out.mp4".
Result<void> refuse_unless(bool used, const SettingsFlags& flags, const std::vector<std::string>& keys,
                           std::string_view why) {
  return used ? Result<void>() : refuse_given(flags, keys, why, ", or");
}

// A recording has its size, its rate, its exposures and their times.
Result<void> check_recorded_camera(const SettingsFlags& flags, const Settings::Camera& camera) {
  if (!is_replayed(camera.id)) return {};
  return refuse_given(
      flags,
      {"camera.format", "camera.width", "camera.height", "camera.framerate", "camera.control_delay",
       "camera.timestamp", "schedule.shutter", "schedule.gain", "schedule.adapt", "schedule.mains"},
      fmt::format("the pictures and exposures of '{}' are recorded and cannot be set", camera.id));
}

// At the fit's pace a recording is read as `replay` reads it, by no camera with buffers, clocks and lines.
Result<void> check_pace(const SettingsFlags& flags, const Settings::Camera& camera) {
  TRY(refuse_unless(is_replayed(camera.id), flags, {"camera.pace"},
                    "the pace is that of a recording in place of the camera; give --camera replay:FILE"));
  return refuse_unless(
      !is_read_as_fast_as_asked(camera), flags,
      {"camera.buffers", "camera.yuv_range", "sync.line", "sync.strobe", "sync.strobe_delay",
       "sync.active_low", "sync.trigger_width", "sync.trigger_gap", "sync.trigger_tolerance",
       "sync.trigger_active_low", "record.memory_mib", "output.http_record"},
      fmt::format("'{}' is read frame by frame as from a disk; give --pace realtime to play it as a camera",
                  camera.id));
}

// What only a strobe or a trigger line has.
Result<void> check_lines(const SettingsFlags& flags, const Settings::Sync& sync) {
  TRY(refuse_unless(!sync.line.empty(), flags, {"sync.strobe", "sync.strobe_delay", "sync.active_low"},
                    "this run reads no strobe line; give --sync-line gpiochip0:17"));
  TRY(refuse_unless(
      !sync.trigger_line.empty(), flags,
      {"sync.trigger_width", "sync.trigger_gap", "sync.trigger_tolerance", "sync.trigger_active_low"},
      "this run drives no trigger line; give --trigger-line gpiochip0:17"));
  return refuse_unless(sync.trigger != TriggerMode::PulseWidth, flags, {"sync.trigger_width"},
                       "with --trigger pulse-width a pulse is as wide as the exposure; give --trigger fsync");
}

Result<void> check_live_page(const SettingsFlags& flags, const Settings::Output& output) {
  return refuse_unless(!output.path(sink_name::kHttp).empty(), flags,
                       {"output.http_token", "output.http_record"},
                       "this run has no live page; give --http 127.0.0.1:8080");
}

// What only some outputs have.
Result<void> check_outputs_of(const SettingsFlags& flags, const Settings::Output& output,
                              const VideoOptions& options) {
  const std::string& frames = output.path(sink_name::kFrames);
  const bool files = frames.ends_with(".exr"), pipe = frames == kStandardOutput,
             video = video_container_of(frames).has_value() || !output.path(sink_name::kVideo).empty(),
             page = !output.path(sink_name::kHttp).empty(),
             shown = video || (pipe && options.pipe != PipeFormat::Half);  // bare radiance is not
  TRY(refuse_unless(files, flags, {"output.layers"}, "this run writes no EXR files; give -o out/%06d.exr"));
  TRY(refuse_unless(files || page, flags, {"output.compression"},
                    "this run writes no EXR files; give -o out/%06d.exr"));
  TRY(refuse_unless(video, flags, {"video.codec", "video.crf"},
                    "this run compresses no video; give -o out.mp4"));
  TRY(refuse_unless(shown, flags, {"video.transfer"}, "this run writes no video; give -o out.mp4"));
  TRY(refuse_unless(shown || page, flags, {"video.white", "video.peak"},
                    "this run writes no video; give -o out.mp4"));
  TRY(refuse_unless(options.transfer != VideoTransfer::Sdr || page, flags, {"video.white", "video.peak"},
                    "a video for SDR displays is as bright as its display; give --transfer pq or hlg"));
  return refuse_unless(pipe, flags, {"video.pipe_format"}, "no frames go to the standard output; give -o -");
}

}  // namespace

Result<void> check_ignored_flags(const SettingsFlags& flags, const Settings& settings) {
  TRY(check_recorded_camera(flags, settings.camera));
  TRY(check_pace(flags, settings.camera));
  TRY(check_lines(flags, settings.sync));
  TRY(check_live_page(flags, settings.output));
  TRY(refuse_unless(!settings.record.file.empty() || !settings.output.http_takes.empty(), flags,
                    {"record.codec"}, "this run writes no recording; give --record walk.mkv"));
  return check_outputs_of(flags, settings.output, settings.video);
}

Result<void> check_flags_on_display(const SettingsFlags& flags, const VideoOptions& options) {
  std::vector<std::string> brightness{"video.white", "video.peak"};
  if (options.transfer != VideoTransfer::Sdr) brightness.emplace_back("video.transfer");
  return refuse_given(flags, brightness, "--exposure and --ldr make pictures for SDR displays");
}

Result<void> check_flags_on_snapshot(const SettingsFlags& flags, const std::string& snapshot) {
  std::vector<std::string> fit{"knobs"};
  for (const SettingField& field : setting_fields())
    if (field.group == SettingGroup::Fit && field.key != "fit.threads" && field.key != "fit.backend")
      fit.push_back(field.key);
  return refuse_given(flags, fit, fmt::format("the scene of '{}' is fitted already", snapshot));
}

}  // namespace hdrcam
