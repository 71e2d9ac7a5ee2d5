#include "firmware_host/film/film_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "capture/exposure.h"
#include "firmware_host/film/steady_path.h"
#include "firmware_host/settings/named_knobs.h"
#include "firmware_host/settings/seconds_text.h"
#include "firmware_host/settings/without_field.h"
#include "hal/core/image.h"
#include "hal/core/parse_number.h"
#include "hal/core/sound_facts.h"
#include "hal/recording/recording.h"

namespace hdrcam {
namespace {

constexpr int kMostFrames = 1'000'000, kLeastSide_px = 16;
constexpr double kNearly_s = 1e-6;  // times are rounded to nanoseconds
// Of a frame: a time since 1970, as a double, is exact to a quarter of a microsecond.
constexpr double kNearlyFrame = 1e-3;

Result<void> check_number(const char* flag, double value, double least, double most) {
  if (value >= least && value <= most) return {};
  return Error{ErrorCode::Invalid,
               fmt::format("{} takes a number, {}..{}, not {}", flag, least, most, value)};
}

Result<void> check_inside(double time_s, const FilmedRecording& recording) {
  if (time_s >= recording.begin_s - kNearly_s && time_s <= recording.duration_s + kNearly_s) return {};
  return Error{ErrorCode::Invalid,
               fmt::format("--time {:g} is outside the {}, which spans {:.6g} to {:.6g} s", time_s,
                           recording.is_snapshot() ? "snapshot" : "recording", recording.begin_s,
                           recording.duration_s)};
}

// "0.5" freezes that moment; "0.2..0.8" is a part of the recording; "end" is its last moment.
Result<void> plan_time(const std::string& text, const FilmedRecording& recording, FilmPlan& plan) {
  plan.begin_s = recording.begin_s, plan.end_s = recording.duration_s;
  if (text.empty()) return {};
  const std::size_t dots = text.find("..");
  plan.frozen = dots == std::string::npos;
  const auto moment = [&](std::string_view word) {
    return word == "end" ? std::optional(recording.duration_s) : seconds_of(word);
  };
  const auto from = moment(std::string_view(text).substr(0, dots));
  const auto to = plan.frozen ? from : moment(std::string_view(text).substr(dots + 2));
  if (!from || !to)
    return Error{ErrorCode::Invalid, fmt::format("--time takes a moment in seconds, such as 0.5, or a part, "
                                                 "such as 0.2..0.8 or 0.2..end, not '{}'",
                                                 text)};
  if (*from > *to)
    return Error{ErrorCode::Invalid,
                 fmt::format("--time {} ends before it begins; give the earlier moment first", text)};
  TRY(check_inside(*from, recording));
  TRY(check_inside(*to, recording));
  plan.begin_s = *from, plan.end_s = *to;
  return {};
}

Result<void> plan_size(const std::string& text, const FilmedRecording& recording, FilmPlan& plan) {
  plan.width = recording.width, plan.height = recording.height;
  if (text.empty()) return {};
  const auto side = [](std::string_view part) {
    const auto length_px = parse_number<int>(part);
    return length_px && *length_px >= kLeastSide_px && *length_px <= kMaxSidePx ? length_px : std::nullopt;
  };
  const std::string_view sides = text;
  const std::size_t by = sides.find('x');
  const auto width = side(sides.substr(0, by));
  const auto height = by == sides.npos ? std::nullopt : side(sides.substr(by + 1));
  if (!width || !height)
    return Error{ErrorCode::Invalid, fmt::format("--size takes WIDTHxHEIGHT in pixels, each {}..{}, such as "
                                                 "1280x720, not '{}'",
                                                 kLeastSide_px, kMaxSidePx, text)};
  plan.width = *width, plan.height = *height;
  return {};
}

Result<void> plan_exposure(const FilmOptions& options, const FilmedRecording& recording, FilmPlan& plan) {
  if (options.ldr) plan.exposure = 0;
  if (options.exposure.empty()) return {};
  const auto exposure = parse_duration(options.exposure);
  if (!exposure)
    return Error{ErrorCode::Invalid,
                 fmt::format("--exposure takes a time, such as 4ms or 1/250, not '{}'", options.exposure)};
  if (!recording.has_exposure_times)
    return Error{ErrorCode::Invalid,
                 "--exposure is a time, but of this recording's exposures only the ratios are known; give "
                 "--ldr, for the reference exposure"};
  plan.exposure = to_seconds(exposure.value());
  return {};
}

Result<void> check_unit(const char* flag, bool in_metres, const FilmedRecording& recording, PoseKind pose) {
  if (!in_metres || (recording.has_poses && pose == PoseKind::Given)) return {};
  if (pose == PoseKind::Fixed || recording.stands_still)
    return Error{ErrorCode::Invalid,
                 fmt::format("{} is in metres, but a camera that is taken to stand still shows no length; {} "
                             "--set pose=fixed, or give it without a unit, such as 0.02",
                             flag, recording.is_snapshot() ? "save the scene without" : "leave out")};
  return Error{
      ErrorCode::Invalid,
      fmt::format("{} is in metres, but the poses are tracked and have no metres; give it in units of the "
                  "scene, where 1 is the median depth of the first frame, such as 0.02",
                  flag)};
}

Result<ViewPath> view_of(Storage& storage, const FilmOptions& options) {
  if (!options.view.empty() && !options.path.empty())
    return Error{ErrorCode::Invalid, "--view holds one pose and --path moves it; give one of them"};
  return options.path.empty() ? ViewPath::parse_view(options.view)
                              : ViewPath::read_path(storage, options.path);
}

// Between the eyes; 0 of a film for one.
Result<SceneLength> baseline_of(const FilmOptions& options) {
  if (options.stereo.empty()) return SceneLength{};
  const SceneLength baseline = TRY(parse_length("--stereo", options.stereo));
  if (baseline.value > 0) return baseline;
  return Error{
      ErrorCode::Invalid,
      fmt::format("--stereo takes the distance between the eyes, above 0, not '{}'", options.stereo)};
}

// At a frozen moment only the blur of a photograph depends on the speed.
Result<void> plan_speed(const FilmOptions& options, FilmPlan& plan) {
  TRY(check_number("--speed", options.speed, 0.001, 1000));
  plan.speed = options.speed;
  if (!plan.frozen || plan.speed == 1 || (!plan.view.is_path() && options.shutter_deg > 0)) return {};
  return Error{ErrorCode::Invalid,
               fmt::format("--time {} freezes a moment, so that --speed changes nothing; leave out --speed, "
                           "or show a part, such as --time 0.2..0.8",
                           options.time)};
}

// Whether there is a field: in the snapshot, or in the run on the recording.
Result<void> check_depth_is_known(const FilmedRecording& recording, const Settings::Fit& fit) {
  if (recording.kind == FilmedKind::SnapshotWithoutField)
    return Error{ErrorCode::Invalid,
                 "another view needs the depth that the field knows, and the snapshot was saved without one; "
                 "save it again without --emit state and --set field=none"};
  const std::string_view without_field = what_leaves_out_field(fit);
  if (without_field.empty()) return {};
  return Error{ErrorCode::Invalid,
               fmt::format("another view needs the depth that the field knows; leave out {}", without_field)};
}

Result<void> plan_geometry(Storage& storage, const FilmOptions& options, const Settings::Fit& fit,
                           const FilmedRecording& recording, FilmPlan& plan) {
  plan.view = TRY(view_of(storage, options));
  const SceneLength baseline = TRY(baseline_of(options));
  plan.baseline = baseline.value;
  const bool needs_depth = !plan.view.in_place() || plan.baseline > 0 || options.stabilize;
  if (needs_depth) TRY(check_depth_is_known(recording, fit));
  const PoseKind pose = named_knobs(fit).pose;
  TRY(check_unit("--view", plan.view.in_metres(), recording, pose));
  return check_unit("--stereo", baseline.in_metres, recording, pose);
}

}  // namespace

Result<FilmedRecording> look_through(Storage& storage, const std::string& path,
                                     const std::atomic<bool>& stop) {
  const auto reader = TRY(open_recording(storage, path, Damage::IsSkipped));
  const CameraFacts& camera = reader->camera();
  FilmedRecording recording{
      .framerate_hz = camera.framerate_hz, .width = camera.width, .height = camera.height};
  bool any = false;
  for (;;) {
    if (stop) return Error{ErrorCode::Interrupted, "stopped before the first frame of the film"};
    auto facts = reader->next_facts();
    if (!facts && facts.error().code == ErrorCode::Truncated && any) return recording;
    if (!facts) return facts.error();
    if (!facts.value()) return recording;
    const FrameFacts& frame = **facts;
    if (!any) recording.first = frame.timestamp, recording.has_poses = frame.T_world_camera.has_value();
    any = true;
    recording.has_exposure_times &= frame.has_exposure_time();
    recording.duration_s = std::max(recording.duration_s, to_seconds(frame.timestamp - recording.first));
  }
}

Result<FilmPlan> plan_film(Storage& storage, const FilmOptions& options, const Settings::Fit& fit,
                           const FilmedRecording& recording) {
  FilmPlan plan;
  TRY(plan_geometry(storage, options, fit, recording, plan));
  TRY(plan_time(options.time, recording, plan));
  TRY(plan_size(options.size, recording, plan));
  TRY(plan_exposure(options, recording, plan));
  plan.first = recording.first;
  plan.stabilize = options.stabilize;
  TRY(plan_speed(options, plan));
  TRY(check_number("--framerate", options.framerate_hz, options.framerate_hz == 0 ? 0 : 0.1, 1000));
  TRY(check_number("--shutter-angle", options.shutter_deg, 0, 360));
  plan.framerate_hz = options.framerate_hz > 0 ? options.framerate_hz : recording.framerate_hz;
  plan.shutter_s = options.shutter_deg / 360 / plan.framerate_hz;
  const double length_s =
      plan.frozen ? (plan.view.is_path() ? plan.view.end_s() : 0) : (plan.end_s - plan.begin_s) / plan.speed;
  const double frames = std::floor(length_s * plan.framerate_hz + kNearlyFrame) + 1;
  if (frames > kMostFrames)
    return Error{
        ErrorCode::Invalid,
        fmt::format("the film would have {:.0f} frames, more than {}; {} or lower --framerate", frames,
                    kMostFrames, plan.frozen ? "let the path of the view end earlier" : "raise --speed")};
  plan.frames = static_cast<int>(frames);
  return plan;
}

std::uint64_t view_bytes(const FilmPlan& plan) {
  constexpr std::uint64_t kView = 400;  // of a pixel: meshes, what they show, the field's view, both eyes
  return kView * pixel_count(plan.height, plan.width);
}

std::uint64_t film_bytes(const FilmPlan& plan, const FilmedRecording& recording) {
  constexpr std::uint64_t kKeyframe = 90;  // of a pixel: with its depth and both motions
  const double kept_s = std::min(recording.duration_s,
                                 plan.scene_shutter_s() + (plan.stabilize ? 2 * SteadyPath::kReach_s : 0));
  const auto keyframes = static_cast<std::uint64_t>(kept_s * recording.framerate_hz) + 4;
  return kKeyframe * keyframes * pixel_count(recording.height, recording.width) + view_bytes(plan);
}

}  // namespace hdrcam
