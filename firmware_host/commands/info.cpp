// hdrcam info x.mkv: shows the content of a recording and whether it is complete; if not, it ends with an
// error.
#include <CLI/CLI.hpp>
#include <memory>

#include "firmware_host/commands/command.h"
#include "firmware_host/commands/recording_summary.h"
#include "firmware_host/terminal.h"

namespace hdrcam {
namespace {

struct InfoOptions {
  std::string recording;
  bool json = false;
};

Result<void> show(Surroundings& around, const InfoOptions& options) {
  const auto summary = TRY(summarize(around.storage, options.recording));
  say("{}", options.json ? as_json(summary, options.recording) : as_table(summary, options.recording));
  if (summary.end) return *summary.end;
  if (const std::string damage = summary.left_out.sentence(); !damage.empty())
    return Error{ErrorCode::Corrupt, fmt::format("'{0}' is damaged: {1}; 'hdrcam repair {0} -o FILE' writes "
                                                 "the others",
                                                 options.recording, damage)};
  return {};
}

}  // namespace

void add_info(CLI::App& app, Verb& chosen) {
  auto options = std::make_shared<InfoOptions>();
  CLI::App* verb = app.add_subcommand("info", "show the content of a recording and whether it is complete");
  verb->add_option("recording", options->recording, "the recording (.mkv)")->required();
  verb->add_flag("--json", options->json, "as JSON, for programs");
  verb->callback(
      [options, &chosen] { chosen = [options](Surroundings& around) { return show(around, *options); }; });
}

}  // namespace hdrcam
