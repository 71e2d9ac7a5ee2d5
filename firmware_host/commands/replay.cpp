// hdrcam replay RECORDING -o out/%06d.exr: turns a recording into HDR frames.
#include <memory>
#include <string>

#include "firmware_host/commands/command.h"
#include "firmware_host/commands/kept_work.h"
#include "firmware_host/commands/no_snapshot.h"
#include "firmware_host/commands/recording_run.h"
#include "firmware_host/commands/run_files.h"
#include "firmware_host/commands/run_limits.h"
#include "firmware_host/commands/with_settings.h"
#include "firmware_host/run/novel_views.h"
#include "firmware_host/run/output_needs.h"
#include "firmware_host/sinks/frame_pattern.h"
#include "firmware_host/sinks/sink_name.h"

namespace hdrcam {
namespace {

struct ReplayFlags {
  std::string recording, truth;
  int frames = 0;
  bool strict = false;
  KeptWork kept;
  std::unique_ptr<SettingsFlags> settings;
};

std::string command_line_of(const ReplayFlags& flags, const Settings& settings) {
  std::string text =
      fmt::format("hdrcam replay {}", shell_word(flags.recording)) + flags.settings->as_flags(settings);
  if (flags.frames > 0) text += fmt::format(" --frames {}", flags.frames);
  if (!flags.truth.empty()) text += " --truth " + shell_word(flags.truth);
  if (flags.strict) text += " --strict";
  return text;
}

std::vector<NamedInput> inputs_of(const ReplayFlags& flags) {
  std::vector<NamedInput> inputs{{"the file that is read", flags.recording}};
  if (flags.truth.empty()) return inputs;
  for (NamedInput& file : files_of_clip(flags.truth)) inputs.push_back(std::move(file));
  return inputs;
}

std::vector<NamedOutput> outputs_of(const ReplayFlags& flags, const Settings& settings, Storage& storage) {
  std::vector<NamedOutput> outputs = outputs_of(settings, sink_kinds());
  if (!flags.truth.empty() && NovelViews::are_of(storage, flags.truth))
    outputs.push_back({"the novel views beside --output",
                       NovelViews::files_beside(settings.output.path(sink_name::kFrames)), OutputKind::Frames,
                       ".exr"});
  return outputs;
}

bool is_numbered_only(const std::string& frames) {
  const auto pattern = FramePattern::parse("--output", frames, ".exr");
  return pattern && pattern.value().name_before().empty() && pattern.value().name_after() == ".exr";
}

// truth: the clip; frames: where --output writes what is scored, from the disk and by its numbers.
Result<void> check_truth(const std::string& truth, const std::string& frames, Storage& storage) {
  if (!frames.ends_with(".exr"))
    return Error{ErrorCode::Invalid, "--truth scores the HDR frames on disk; give --output out/%06d.exr too"};
  if (!is_numbered_only(frames))
    return Error{ErrorCode::Invalid,
                 fmt::format("--truth scores frames that are named by their number alone; give --output "
                             "out/%06d.exr instead of '{}'",
                             frames)};
  return check_clip_folder(storage, truth);
}

Result<void> replay(const ReplayFlags& flags, const Settings& asked, Surroundings& around) {
  TRY(check_recording_named(around.storage, flags.recording, "replay"));
  TRY(check_no_snapshot(around.storage, flags.recording));
  if (!flags.truth.empty())
    TRY(check_truth(flags.truth, asked.output.path(sink_name::kFrames), around.storage));
  if (!writes_outputs(asked.output))
    return Error{
        ErrorCode::Invalid,
        "nothing to write; give --output out/%06d.exr or out.mp4, --preview, --sheet, --stats or --report; "
        "'hdrcam replay --help' lists all"};
  const Settings settings = TRY(settings_on_recording(*flags.settings, asked));
  TRY(check_needs(settings));
  TRY(check_recorded_poses(flags.recording, settings, around));
  TRY(flags.kept.check(around.storage, inputs_of(flags), outputs_of(flags, settings, around.storage)));
  const auto source = TRY(RecordingSource::open(
      around.storage, flags.recording,
      {.frames = flags.frames, .contradiction = flags.strict ? Contradiction::Fails : Contradiction::Warns},
      around.stop));
  TRY(admit_fit(settings, source->camera(), flags.truth.empty() ? FieldUse::Fills : FieldUse::Seen));
  return run_on(*source,
                {.settings = settings,
                 .title = title_of(source->camera(), flags.recording),
                 .command = command_line_of(flags, settings),
                 .truth = flags.truth,
                 .stop = &around.stop},
                around.storage);
}

}  // namespace

void add_replay(CommandLine program, Verb& chosen) {
  auto flags = std::make_shared<ReplayFlags>();
  CommandLine verb = program.add_verb("replay", "turn a recording into HDR frames");
  verb.add_option("recording", flags->recording, "the recording (docs/recording.md)").check(names_input);
  verb.add_option("--frames", flags->frames, "frames to take [all]").check(counts_frames());
  verb.add_option("--truth", flags->truth,
                  "a clip with ground truth: scores in the report, and the field's views from the clip's "
                  "other cameras beside the frames, in novel/")
      .check(names_file);
  verb.add_switch(
      "--strict", flags->strict,
      "fail at a damaged frame and where pictures contradict an exposure, instead of going on with a "
      "warning");
  flags->kept.add_to(verb);
  flags->settings = std::make_unique<SettingsFlags>(
      verb, kRecordingRunGroups, std::vector<std::string>{"output.http_record"});  // of a camera
  verb.on_chosen([flags, &chosen] { chosen = with_settings(flags, replay); });
}

}  // namespace hdrcam
