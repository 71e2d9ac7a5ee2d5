// hdrcam repair in.mkv -o out.mkv: the whole frames of a recording that was cut or damaged, as a recording
// that is complete.
#include <memory>

#include "firmware_host/commands/command.h"
#include "firmware_host/commands/kept_work.h"
#include "firmware_host/commands/no_snapshot.h"
#include "firmware_host/commands/recording_name.h"
#include "firmware_host/commands/with_settings.h"
#include "firmware_host/run/memory_need.h"
#include "firmware_host/settings/start_time.h"
#include "firmware_host/terminal.h"
#include "hal/core/counted.h"
#include "hal/recording/recording.h"

namespace hdrcam {
namespace {

struct RepairOptions {
  std::string recording, output;
  KeptWork kept;
  std::unique_ptr<SettingsFlags> settings;
};

struct Saved {
  int frames = 0;
  std::string cut;  // why nothing comes after them; empty at a proper end
};

// A frame keeps its number, so that what is missing before it stays visible, and says so.
Result<Saved> copy_whole_frames(Surroundings& around, RecordingReader& from, const std::string& path) {
  auto writer = TRY(create_recording(around.storage, path, from.camera(), Creation::New, from.codec()));
  Saved saved;
  std::uint64_t left_out = 0;
  for (;; ++saved.frames) {
    if (around.stop)
      return Error{ErrorCode::Interrupted,
                   fmt::format("stopped after {}; nothing was written", counted(saved.frames, "frame"))};
    auto frame = from.next();
    if (!frame && frame.error().code != ErrorCode::Truncated) return frame.error();
    if (!frame) saved.cut = frame.error().message;
    if (!frame || !frame.value()) break;
    if (from.left_out().count > left_out) (*frame)->facts.flags |= kFrameAfterDrop;
    left_out = from.left_out().count;
    TRY(writer->append(**frame));
  }
  TRY(writer->finish());
  return saved;
}

Result<void> repair(const RepairOptions& options, const Settings& settings, Surroundings& around) {
  TRY(check_recording_name(around.storage, "--output", options.output));
  TRY(check_no_snapshot(around.storage, options.recording));
  TRY(options.kept.check(around.storage, {{"the file that is read", options.recording}},
                         {{"--output", options.output, OutputKind::Recording}}));
  const auto reader = TRY(open_recording(around.storage, options.recording, Damage::IsSkipped));
  TRY(admit_copy(settings, reader->camera(), {.codec = reader->codec()}));
  FileInMaking making = TRY(FileInMaking::beside(around.storage, options.output));
  const Saved saved = TRY(making.as_asked(copy_whole_frames(around, *reader, making.path())));
  if (saved.frames == 0) return no_whole_frame(options.recording);
  TRY(making.commit());
  if (!saved.cut.empty()) remark("warning: {}\n", saved.cut);
  for (const std::string& warning : warnings_of(*reader)) remark("warning: {}\n", warning);
  say("{}: {}\n", options.output, counted(saved.frames, "frame"));
  return {};
}

}  // namespace

void add_repair(CommandLine program, Verb& chosen) {
  auto options = std::make_shared<RepairOptions>();
  CommandLine verb =
      program.add_verb("repair", "write the whole frames of a cut or damaged recording as a complete one");
  verb.add_option("recording", options->recording, "the recording (.mkv)").required().check(names_input);
  verb.add_option("-o,--output", options->output, "the recording to write (.mkv)")
      .required()
      .transform(named_at_start)
      .check(names_file);
  options->kept.add_to(verb);
  options->settings = std::make_unique<SettingsFlags>(verb, std::vector<std::string>{"machine.memory_mib"});
  verb.on_chosen([options, &chosen] { chosen = with_settings(options, repair); });
}

}  // namespace hdrcam
