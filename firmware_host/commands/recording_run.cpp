#include "firmware_host/commands/recording_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "firmware_host/commands/ignored_flags.h"
#include "firmware_host/commands/trace_file.h"
#include "firmware_host/run/memory_need.h"
#include "firmware_host/run/output_needs.h"
#include "firmware_host/run/pipeline.h"
#include "firmware_host/settings/start_time.h"
#include "firmware_host/sinks/scene_files/posed_clip.h"
#include "firmware_host/terminal.h"
#include "hal/clock.h"
#include "hal/recording/recording.h"

namespace hdrcam {

Result<void> check_recording_named(Storage& storage, const std::string& recording, const char* verb) {
  if (recording.empty())
    return Error{ErrorCode::Invalid,
                 fmt::format("no recording; name one, such as walk.mkv; see 'hdrcam {} --help'", verb)};
  if (TRY(storage.look_at(recording)).kind == FileKind::Missing)
    return Error{ErrorCode::NotFound, fmt::format("'{}' does not exist", recording)};
  return {};
}

Result<Settings> settings_on_recording(const SettingsFlags& flags, const Settings& asked) {
  TRY(check_ignored_flags(flags, asked));
  Settings settings = with_start_time(asked, posix_clock().wall_time());
  settings.output.http_takes.clear();
  return settings;
}

bool writes_outputs(const Settings::Output& output) {
  return std::ranges::any_of(output.paths, [](const auto& sink) { return !sink.second.empty(); });
}

Result<void> check_recorded_poses(const std::string& recording, const Settings& settings,
                                  Surroundings& around) {
  if (!needs_of(settings.output).poses) return {};
  const std::string name = fmt::format("'{}'", recording);
  const bool tracks = tracks_poses(settings);
  if (options_of(settings, FieldUse::Fills).knobs.pose != PoseKind::Given)
    return check_tracked_poses(settings, "--set pose takes none of " + name);
  const auto reader = open_recording(around.storage, recording, Damage::IsSkipped);
  if (!reader) return {};  // why it does not open is the run's to tell
  const bool has_lens = reader.value()->camera().intrinsics.has_value();
  if (has_lens && tracks) return {};
  for (;;) {
    const auto next = reader.value()->next_facts();
    if (!next || around.stop) return {};  // as is what ends it, ^C too
    if (!next.value()) return check_tracked_poses(settings, name + " states none");
    const FrameFacts& facts = *next.value();
    if (is_kept_out(facts)) continue;
    if (facts.T_world_camera) return check_lens(PoseSource::Given, !has_lens, name);
    if (tracks) return {};
  }
}

Result<void> admit_fit(const Settings& settings, const CameraFacts& clip, FieldUse use) {
  if (sees_field_in_scene(settings.output, RunPace::Clip)) use = FieldUse::Seen;
  return admit_parts(settings, fmt::format("the fit of pictures of {}x{}", clip.width, clip.height),
                     recording_bytes(clip) + fit_bytes(clip.width, clip.height, settings, use));
}

std::string title_of(const CameraFacts& clip, const std::string& file) {
  return clip.name.empty() ? std::filesystem::path(file).stem().string() : clip.name;
}

Result<void> run_on(RecordingSource& source, RunPlan plan, Storage& storage) {
  TraceFile trace(plan.settings);
  plan.trace = trace.trace();
  Result<void> ended = trace.write_after(run(plan, source, storage), storage);
  show_warnings(source);
  return ended;
}

void show_warnings(const RecordingSource& source) {
  for (const std::string& warning : source.warnings()) remark("warning: {}\n", warning);
}

}  // namespace hdrcam
