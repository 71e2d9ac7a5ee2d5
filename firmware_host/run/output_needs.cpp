#include "firmware_host/run/output_needs.h"

#include <fmt/format.h>

#include "firmware_host/run/pipeline_options.h"
#include "firmware_host/settings/without_field.h"
#include "firmware_host/sinks/frame_pattern.h"
#include "firmware_host/sinks/live_view/live_view.h"
#include "firmware_host/sinks/sink_name.h"
#include "firmware_host/sinks/sink_set.h"
#include "firmware_host/terminal.h"
#include "firmware_host/web/http_address.h"
#include "render/white_balance.h"

namespace hdrcam {
namespace {

// Motion and depth are written twice: as channels of the EXR files and as files of their own.
struct MotionOrDepth {
  const char* word;  // of --layers
  bool ExrLayers::*layer;
  std::string_view sink;
  const char* flag;
  bool OutputNeeds::*need;
  bool is_motion = false, is_of_field = false;
};
constexpr MotionOrDepth kMotionAndDepth[] = {
    {.word = "depth",
     .layer = &ExrLayers::depth,
     .sink = sink_name::kDepth,
     .flag = "--depth",
     .need = &OutputNeeds::depth,
     .is_of_field = true},
    {.word = "flow",
     .layer = &ExrLayers::flow,
     .sink = sink_name::kFlowBackward,
     .flag = "--flow-backward",
     .need = &OutputNeeds::flow_backward,
     .is_motion = true},
    {.word = "flow_forward",
     .layer = &ExrLayers::flow_forward,
     .sink = sink_name::kFlowForward,
     .flag = "--flow-forward",
     .need = &OutputNeeds::flow_forward,
     .is_motion = true},
    {.word = "field_flow",
     .layer = &ExrLayers::field_flow,
     .sink = sink_name::kFieldFlowBackward,
     .flag = "--field-flow-backward",
     .need = &OutputNeeds::field_flow,
     .is_motion = true,
     .is_of_field = true},
    {.word = "field_flow_forward",
     .layer = &ExrLayers::field_flow_forward,
     .sink = sink_name::kFieldFlowForward,
     .flag = "--field-flow-forward",
     .need = &OutputNeeds::field_flow,
     .is_motion = true,
     .is_of_field = true},
};

bool is_written(const Settings::Output& output, std::string_view sink) { return !output.path(sink).empty(); }

// The first of them that is wanted, as it was asked for; "" for none.
std::string first_asked(const Settings::Output& output, bool MotionOrDepth::*kind) {
  for (const MotionOrDepth& one : kMotionAndDepth) {
    if (!(one.*kind)) continue;
    if (is_written(output, one.sink)) return one.flag;
    if (output.layers.*one.layer) return fmt::format("--layers {}", one.word);
  }
  return "";
}

// A name of pictures that numbers them wrongly is refused for that, not as if there were no pictures.
Result<void> check_numbered(std::string_view flag, const std::string& path) {
  for (const char* extension : {".exr", ".png"})
    if (path.ends_with(extension)) TRY(FramePattern::parse(flag, path, extension));
  return {};
}

Result<void> check_live_page(const Settings::Output& output) {
  const std::string& address = output.path(sink_name::kHttp);
  if (address.empty()) return {};
  TRY(parse_http_address(address));
  return check_http_token(output.http_token);
}

// Poses are of pictures that the run leaves.
Result<void> check_posed_pictures(const Settings::Output& output) {
  if (!needs_of(output).poses) return {};
  TRY(check_numbered("--output", output.path(sink_name::kFrames)));
  TRY(check_numbered("--preview", output.path(sink_name::kPreview)));
  const PicturePatterns patterns = patterns_of(output.paths);
  if (is_written(output, sink_name::kTransforms)) TRY(pictures_of("--transforms", patterns));
  if (is_written(output, sink_name::kColmap)) TRY(pictures_of_colmap(patterns));
  return {};
}

// What is shown of the field needs one.
Result<void> check_field_is_there(const Settings& settings) {
  const std::string shown = settings.fit.emit == EmitLayer::Field
                                ? "--emit field"
                                : first_asked(settings.output, &MotionOrDepth::is_of_field);
  const std::string_view without_field = what_leaves_out_field(settings.fit);
  if (shown.empty() || without_field.empty()) return {};
  return Error{ErrorCode::Invalid, fmt::format("{} comes from the field, which {} leaves out; leave out one "
                                               "of them",
                                               shown, without_field)};
}

}  // namespace

OutputNeeds needs_of(const Settings::Output& output) {
  OutputNeeds needs;
  for (const MotionOrDepth& one : kMotionAndDepth)
    if (output.layers.*one.layer || is_written(output, one.sink)) needs.*one.need = true;
  needs.poses = is_written(output, sink_name::kTransforms) || is_written(output, sink_name::kColmap);
  needs.points = is_written(output, sink_name::kColmap);
  needs.scene = is_written(output, Settings::Output::kSnapshot);
  return needs;
}

std::string note_on_motion(const Settings& settings, const CameraFacts& camera) {
  constexpr int kFitToNext = 2;  // later frames, until the field was fitted to the next one
  const Settings::Output& output = settings.output;
  if (!output.layers.field_flow_forward && !is_written(output, sink_name::kFieldFlowForward)) return "";
  const Knobs knobs = options_of(settings, FieldUse::Fills).knobs;
  if (look_ahead_of(knobs, camera.height, camera.width) >= kFitToNext) return "";
  return "the field's motion to the next frame is a guess, as frames leave before the field is fitted to the "
         "next one; give --lookahead 2";
}

std::string motion_output(const Settings::Output& output) {
  return first_asked(output, &MotionOrDepth::is_motion);
}

bool sees_field_in_scene(const Settings::Output& output, RunPace pace) {
  return is_written(output, Settings::Output::kSnapshot) && pace == RunPace::Clip;
}

ExrCompression compression_of(const Settings::Output& output, RunPace pace) {
  switch (output.compression) {
    case FrameCompression::None:
      return ExrCompression::None;
    case FrameCompression::Rle:
      return ExrCompression::Rle;
    case FrameCompression::Zip:
      return ExrCompression::Zip;
    case FrameCompression::Piz:
      return ExrCompression::Piz;
    case FrameCompression::Auto:
      break;
  }
  return pace == RunPace::Camera ? ExrCompression::None : kUsualCompression;
}

Result<std::optional<ChannelGains>> white_balance_of(const Settings::Output& output,
                                                     const CameraFacts& camera) {
  return white_balance_gains(parse_white_balance(output.white_balance).value(), camera);
}

void write_result_beside_frames(const Settings::Output& output, std::string_view text) {
  (output.path(sink_name::kFrames) == kStandardOutput ? write_remark : write_result)(text);
}

Result<void> check_needs(const Settings& settings) {
  const Settings::Output& output = settings.output;
  if (needs_of(output).flow_forward && options_of(settings, FieldUse::Fills).knobs.look_ahead == 0)
    return Error{ErrorCode::Invalid,
                 "motion to the next frame is known once that frame is there; give --lookahead 1, or --set "
                 "look_ahead=1"};
  if (output.path(Settings::Output::kSnapshot) == kStandardOutput)
    return not_to_standard_output("--snapshot");
  TRY(check_live_page(output));
  TRY(check_posed_pictures(output));
  return check_field_is_there(settings);
}

const char* flag_of_poses(const Settings::Output& output) {
  return is_written(output, sink_name::kTransforms) ? "--transforms" : "--colmap";
}

bool tracks_poses(const Settings& settings) {
  return options_of(settings, FieldUse::Fills).knobs.field != FieldKind::None;
}

Result<void> check_tracked_poses(const Settings& settings, std::string_view cause) {
  if (!needs_of(settings.output).poses || tracks_poses(settings)) return {};
  return Error{
      ErrorCode::Invalid,
      fmt::format("{} needs poses: {}, and none is tracked without the field, which {} leaves out; leave "
                  "out one of them",
                  flag_of_poses(settings.output), cause, what_leaves_out_field(settings.fit))};
}

}  // namespace hdrcam
