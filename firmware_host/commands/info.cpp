// hdrcam info x.mkv: shows the content of a recording, or of a saved scene, and whether it is complete; if
// not, it ends with an error.
#include <memory>

#include "firmware_host/command_line.h"
#include "firmware_host/commands/command.h"
#include "firmware_host/commands/recording_summary.h"
#include "firmware_host/commands/snapshot_summary.h"
#include "firmware_host/cut_recording.h"
#include "firmware_host/terminal.h"

namespace hdrcam {
namespace {

struct InfoOptions {
  std::string recording;
  bool json = false;
};

Result<void> show_snapshot(Surroundings& around, const InfoOptions& options) {
  const SceneHead scene = TRY(check_scene(around.storage, options.recording));
  const std::uint64_t bytes = TRY(around.storage.look_at(options.recording)).size_bytes;
  say("{}",
      options.json ? as_json(scene, options.recording, bytes) : as_table(scene, options.recording, bytes));
  return {};
}

Result<void> show(Surroundings& around, const InfoOptions& options) {
  if (TRY(is_scene_snapshot(around.storage, options.recording))) return show_snapshot(around, options);
  const auto summary = TRY(summarize(around.storage, options.recording, around.stop));
  say("{}", options.json ? as_json(summary, options.recording) : as_table(summary, options.recording));
  if (!summary.behind.empty()) remark("warning: {}\n", summary.behind);
  if (summary.end) {
    if (summary.end->code != ErrorCode::Truncated || summary.frames == 0) return *summary.end;
    return read_to_cut(*summary.end, options.recording);
  }
  const LeftOut& left_out = summary.left_out;
  const std::string damage = left_out.sentence();
  if (damage.empty()) return {};
  // without a lost frame the sentence itself says that the file is damaged
  return Error{ErrorCode::Corrupt,
               fmt::format("'{}' is {}{}; 'hdrcam repair {} -o FILE' writes {}", options.recording,
                           left_out.count > 0 ? "damaged: " : "", damage, shell_word(options.recording),
                           left_out.count > 0 ? "the others" : "a sound one")};
}

}  // namespace

void add_info(CommandLine program, Verb& chosen) {
  auto options = std::make_shared<InfoOptions>();
  CommandLine verb = program.add_verb(
      "info", "show the content of a recording, or of a saved scene, and whether it is complete");
  verb.add_option("recording", options->recording, "the recording (.mkv), or the scene that --snapshot saved")
      .required()
      .check(names_input);
  verb.add_switch("--json", options->json, "as JSON, for programs");
  verb.on_chosen(
      [options, &chosen] { chosen = [options](Surroundings& around) { return show(around, *options); }; });
}

}  // namespace hdrcam
