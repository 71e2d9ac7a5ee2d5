// hdrcam render RECORDING --view 0.1,0,0 -o out/%06d.exr: the scene of a recording, or one that a run saved,
// from another view, at another time, with another shutter or exposure.
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "firmware_host/commands/command.h"
#include "firmware_host/commands/ignored_flags.h"
#include "firmware_host/commands/kept_work.h"
#include "firmware_host/commands/recording_run.h"
#include "firmware_host/commands/run_files.h"
#include "firmware_host/commands/trace_file.h"
#include "firmware_host/commands/with_settings.h"
#include "firmware_host/film/film_plan.h"
#include "firmware_host/film/scene_snapshot.h"
#include "firmware_host/run/memory_need.h"
#include "firmware_host/run/output_needs.h"
#include "firmware_host/run/snapshot_film.h"
#include "firmware_host/sinks/ldr_frames.h"
#include "firmware_host/sinks/run_record.h"
#include "firmware_host/sinks/sink_name.h"
#include "firmware_host/terminal.h"
#include "firmware_host/whole_percent.h"
#include "hal/video/video_writer.h"

namespace hdrcam {
namespace {

struct RenderFlags {
  std::string recording;  // or a snapshot
  FilmOptions options;
  KeptWork kept;
  std::unique_ptr<SettingsFlags> settings;
};

// Outputs of runs that fit, and of recorded frames: what moves between them is known of those alone.
constexpr std::string_view kOfOtherVerbs[] = {Settings::Output::kSnapshot, sink_name::kFlowForward,
                                              sink_name::kFlowBackward, sink_name::kFieldFlowForward,
                                              sink_name::kFieldFlowBackward};

bool is_png(const std::string& path) { return path.ends_with(".png"); }

// The same as channels of the HDR frames.
Result<void> check_motion(const Settings& settings) {
  const std::string motion = motion_output(settings.output);
  if (motion.empty()) return {};
  return Error{ErrorCode::Invalid, fmt::format("{} writes the motion between recorded frames, which a film "
                                               "does not show; use 'hdrcam replay'",
                                               motion)};
}

// 8-bit pictures go where 8-bit pictures can go.
Result<void> check_pictures(const FilmPlan& plan, const Settings& settings) {
  const std::string& frames = settings.output.path(sink_name::kFrames);
  if (!plan.exposure) {
    if (is_png(frames))
      return Error{
          ErrorCode::Invalid,
          fmt::format("'{}' holds 8-bit pictures, which need an exposure; give --exposure 4ms or --ldr, or "
                      "name out/%06d.exr for HDR frames",
                      frames)};
    return {};
  }
  if (!is_png(frames) && !video_container_of(frames) && !frames.empty())
    return Error{ErrorCode::Invalid,
                 fmt::format("--exposure and --ldr make 8-bit pictures, which '{}' does not hold; give "
                             "-o out/%06d.png or out.mp4",
                             frames)};
  return {};
}

// A picture for two eyes has no one lens.
Result<void> check_poses(const FilmPlan& plan, const Settings& settings) {
  if (plan.baseline <= 0) return {};
  for (const std::string_view sink : {sink_name::kTransforms, sink_name::kColmap})
    if (!settings.output.path(sink).empty())
      return Error{
          ErrorCode::Invalid,
          fmt::format("--{} needs pictures of one lens, and --stereo makes two a frame; leave out one of "
                      "them",
                      sink)};
  return {};
}

// What every film is checked by, of a recording or of a snapshot.
Result<void> check_film(const RenderFlags& flags, const FilmPlan& plan, const Settings& settings) {
  TRY(check_pictures(plan, settings));
  if (plan.exposure) TRY(check_flags_on_display(*flags.settings, settings.video));
  TRY(check_poses(plan, settings));
  TRY(check_motion(settings));
  return check_needs(settings);
}

std::span<const SinkKind> sinks_of(const FilmPlan& plan) {
  return plan.exposure ? ldr_sink_kinds() : sink_kinds();
}

// Two eyes lie side by side.
std::uint64_t film_sink_bytes(const FilmPlan& plan, const Settings& settings) {
  return sink_bytes(plan.baseline > 0 ? 2 * plan.width : plan.width, plan.height, settings);
}

Result<void> admit(const Settings& settings, const FilmedRecording& recording, const CameraFacts& camera,
                   const FilmPlan& plan) {
  const std::uint64_t need = recording_bytes(camera) +
                             method_bytes(camera.width, camera.height, settings, FieldUse::Seen) +
                             film_bytes(plan, recording) + film_sink_bytes(plan, settings);
  return admit_parts(settings,
                     fmt::format("a film of {}x{} from pictures of {}x{}", plan.width, plan.height,
                                 camera.width, camera.height),
                     need);
}

// A view past all that was recorded is filmed all the same.
void warn_of_view(const RunRecord& record, const Settings& settings) {
  constexpr std::uint64_t kMostFromField_percent = 90;
  const std::uint64_t percent = whole_percent(record.film_pixels_from_field, record.film_pixels);
  if (settings.fit.emit == EmitLayer::Field || percent < kMostFromField_percent) return;
  remark(
      "warning: no recorded frame shows {} % of the film, which the field made up; take the view "
      "nearer to the recorded camera\n",
      percent);
}

std::string as_flags(const FilmOptions& options) {
  const FilmOptions usual;
  std::string text;
  const auto add = [&](const char* flag, const auto& value, const auto& unset) {
    if (value != unset) text += fmt::format(" {}={}", flag, shell_word(fmt::format("{}", value)));
  };
  add("--view", options.view, usual.view), add("--path", options.path, usual.path);
  add("--time", options.time, usual.time), add("--speed", options.speed, usual.speed);
  add("--framerate", options.framerate_hz, usual.framerate_hz);
  add("--shutter-angle", options.shutter_deg, usual.shutter_deg);
  add("--exposure", options.exposure, usual.exposure);
  add("--size", options.size, usual.size), add("--stereo", options.stereo, usual.stereo);
  if (options.ldr) text += " --ldr";
  if (options.stabilize) text += " --stabilize";
  return text;
}

// With the path of its view. what: "recording".
std::vector<NamedInput> inputs_of(const RenderFlags& flags, const char* what) {
  std::vector<NamedInput> inputs{{fmt::format("the {} that is read", what), flags.recording}};
  if (!flags.options.path.empty()) inputs.push_back({"the path of the view", flags.options.path});
  return inputs;
}

std::string command_line_of(const RenderFlags& flags, const Settings& settings) {
  return "hdrcam render " + shell_word(flags.recording) + as_flags(flags.options) +
         flags.settings->as_flags(settings);
}

// The fit is done, and known to the snapshot: what a file of settings says of one does not count.
Settings without_fit(Settings settings) {
  Settings::Fit fit;
  fit.threads = settings.fit.threads, fit.backend = settings.fit.backend;
  settings.fit = std::move(fit);
  return settings;
}

Result<void> check_depth(const Settings& settings, const FilmedRecording& snapshot) {
  if (snapshot.kind != FilmedKind::SnapshotWithoutField || !needs_of(settings.output).depth) return {};
  return Error{ErrorCode::Invalid,
               "depth comes from the field, and the snapshot was saved without one; leave out --depth and "
               "--layers depth"};
}

// Before the film, which would be whole when its poses turn out to be none.
Result<void> check_poses(const Settings& settings, const SceneHead& scene) {
  if (!needs_of(settings.output).poses || newest_posed(scene) != nullptr) return {};
  return Error{ErrorCode::Invalid,
               fmt::format("{} needs poses, and no frame of the snapshot has one; leave it out, or save the "
                           "scene without --emit state and --set field=none",
                           flag_of_poses(settings.output))};
}

Result<void> render_snapshot(const RenderFlags& flags, const Settings& asked, Surroundings& around) {
  TRY(check_flags_on_snapshot(*flags.settings, flags.recording));
  const Settings settings = without_fit(asked);
  const SceneHead scene = TRY(scene_head(around.storage, flags.recording));
  const FilmedRecording snapshot = filmed(scene);
  const FilmPlan plan = TRY(plan_film(around.storage, flags.options, settings.fit, snapshot));
  TRY(check_depth(settings, snapshot));
  TRY(check_poses(settings, scene));
  TRY(check_film(flags, plan, settings));
  const std::span<const SinkKind> sinks = sinks_of(plan);
  TRY(flags.kept.check(around.storage, inputs_of(flags, "snapshot"), outputs_of(settings, sinks)));
  const std::uint64_t bytes = TRY(around.storage.look_at(flags.recording)).size_bytes;
  TRY(admit_parts(settings,
                  fmt::format("a film of {}x{} from a snapshot of {}x{}", plan.width, plan.height,
                              snapshot.width, snapshot.height),
                  bytes + view_bytes(plan) + film_sink_bytes(plan, settings)));
  TraceFile trace(settings);
  RunRecord record;
  const Result<void> ended =
      trace.write_after(film_snapshot({.settings = settings,
                                       .title = title_of(scene.camera, flags.recording),
                                       .command = command_line_of(flags, settings),
                                       .film = &plan,
                                       .sinks = sinks,
                                       .stop = &around.stop,
                                       .trace = trace.trace(),
                                       .record = &record},
                                      flags.recording, around.storage),
                        around.storage);
  if (ended) warn_of_view(record, settings);
  return ended;
}

Result<void> render_recording(const RenderFlags& flags, const Settings& settings, Surroundings& around) {
  const FilmedRecording recording = TRY(look_through(around.storage, flags.recording, around.stop));
  const FilmPlan plan = TRY(plan_film(around.storage, flags.options, settings.fit, recording));
  TRY(check_film(flags, plan, settings));
  const std::span<const SinkKind> sinks = sinks_of(plan);
  TRY(check_recorded_poses(flags.recording, settings, around));
  TRY(flags.kept.check(around.storage, inputs_of(flags, "recording"), outputs_of(settings, sinks)));
  const auto source = TRY(RecordingSource::open(around.storage, flags.recording, {}, around.stop));
  TRY(admit(settings, recording, source->camera(), plan));
  RunRecord record;
  Result<void> ended = run_on(*source,
                              {.settings = settings,
                               .title = title_of(source->camera(), flags.recording),
                               .command = command_line_of(flags, settings),
                               .film = &plan,
                               .sinks = sinks,
                               .stop = &around.stop,
                               .record = &record},
                              around.storage);
  if (ended) warn_of_view(record, settings);
  return ended;
}

// Without what a file of settings asks of other verbs.
Settings of_a_film(const SettingsFlags& flags, Settings asked) {
  for (const std::string_view output : kOfOtherVerbs) asked.output.paths.erase(std::string(output));
  ExrLayers& layers = asked.output.layers;
  if (flags.given({"output.layers"}).empty())
    layers.flow = layers.flow_forward = layers.field_flow = layers.field_flow_forward = false;
  return asked;
}

Result<void> render(const RenderFlags& flags, const Settings& given, Surroundings& around) {
  TRY(check_recording_named(around.storage, flags.recording, "render"));
  const Settings asked = of_a_film(*flags.settings, given);
  if (!writes_outputs(asked.output))
    return Error{ErrorCode::Invalid, "nothing to write; give --output out/%06d.exr or out.mp4"};
  const Settings settings = TRY(settings_on_recording(*flags.settings, asked));
  return TRY(is_scene_snapshot(around.storage, flags.recording)) ? render_snapshot(flags, settings, around)
                                                                 : render_recording(flags, settings, around);
}

void add_view_flags(CommandLine verb, FilmOptions& options) {
  constexpr const char* kGroup = "View";
  verb.add_option(
          "--view", options.view,
          "where the camera stands, as the recorded one sees it: dx,dy,dz to the right, down and forward "
          "(in metres where the recording has poses, else 1 is the median depth of its first frame), then "
          "optionally yaw,pitch,roll in degrees, to the right, up and clockwise: 0.1,0,0 or 0.1,0,0,-5,0,0")
      .group(kGroup);
  verb.add_option(
          "--path", options.path,
          "a file that moves the camera: CSV or JSON with time_s,dx,dy,dz,yaw,pitch,roll, time_s of the film")
      .check(names_file)
      .group(kGroup);
  verb.add_option(
          "--time", options.time,
          "freeze this moment, seconds from the recording's first frame: 0.5, or end; or show this part: "
          "0.2..0.8")
      .group(kGroup);
  verb.add_option("--speed", options.speed,
                  "seconds of the recording in a second of the film: 0.25 is slow motion [1]")
      .group(kGroup);
  verb.add_option("--framerate", options.framerate_hz, "frames per second of the film [the recording's]")
      .group(kGroup);
  verb.add_option(
          "--shutter-angle", options.shutter_deg,
          "motion blur added again: the exposure in degrees, 360 being a film frame's interval [0: sharp]")
      .group(kGroup);
  verb.add_switch("--ldr", options.ldr,
                  "8-bit pictures as the camera would have taken them, by its estimated response")
      .group(kGroup);
  verb.add_option(
          "--exposure", options.exposure,
          "exposure of the 8-bit pictures, at a gain of 1: 4ms, 1/250; sets --ldr [the reference exposure]")
      .group(kGroup);
  verb.add_option("--size", options.size,
                  "pixels: 1280x720; the scene is cropped to fill it [the recording's]")
      .group(kGroup);
  verb.add_option("--stereo", options.stereo,
                  "pictures of the left and right eye side by side, the eyes this far apart: 63mm where the "
                  "recording has poses, else 0.02, in the unit of --view")
      .group(kGroup);
  verb.add_switch("--stabilize", options.stabilize, "take the shake out of the recorded camera's path")
      .group(kGroup);
}

// All frames of a film count, and its page has no camera to record.
std::vector<std::string> not_of_a_film() {
  std::vector<std::string> keys{"fit.deadline", "output.http_record"};
  for (const std::string_view output : kOfOtherVerbs) keys.push_back(fmt::format("output.{}", output));
  return keys;
}

}  // namespace

void add_render(CommandLine program, Verb& chosen) {
  auto flags = std::make_shared<RenderFlags>();
  CommandLine verb =
      program.add_verb("render", "show a recording's scene from any view, at any time and exposure");
  verb.add_option("recording", flags->recording,
                  "the recording (docs/recording.md), or a scene that --snapshot of replay or live "
                  "saved (docs/snapshot.md)")
      .check(names_input);
  add_view_flags(verb, flags->options);
  flags->kept.add_to(verb);
  flags->settings = std::make_unique<SettingsFlags>(verb, kRecordingRunGroups, not_of_a_film());
  constexpr const char* kOutput =
      "HDR frames, numbered from 0: out/%06d.exr; 8-bit pictures of --ldr: out/%06d.png; a video: out.mp4 "
      "(.mov, .mkv); or -, the standard output, without --ldr (\"\": none)";
  verb.flag("--output").describe(kOutput);
  verb.flag("--layers").describe("more EXR channels (any of depth,confidence,provenance; \"\": none)");
  verb.on_chosen([flags, &chosen] { chosen = with_settings(flags, render); });
}

}  // namespace hdrcam
