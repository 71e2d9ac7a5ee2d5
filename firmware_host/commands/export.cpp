// hdrcam export x.mkv -o FOLDER: writes a recording as images and a clip.json, bit by bit the same.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "firmware_host/commands/command.h"
#include "firmware_host/run/memory_need.h"
#include "firmware_host/settings/settings_flags.h"
#include "firmware_host/terminal.h"
#include "hal/recording/image_sequence.h"
#include "hal/recording/recording.h"

namespace hdrcam {
namespace {

struct ExportOptions {
  std::string recording, folder;
  bool strict = false;
  std::unique_ptr<SettingsFlags> settings;
};

// A truncated or damaged recording gives its whole frames and a message on stderr.
Result<void> export_recording(Surroundings& around, const ExportOptions& options) {
  const Settings settings = TRY(options.settings->read(around.storage));
  if (options.settings->print_config()) return say("{}", options.settings->printed(settings)), Result<void>{};
  auto reader = TRY(
      open_recording(around.storage, options.recording, options.strict ? Damage::Ends : Damage::IsSkipped));
  TRY(admit_copy(settings, reader->camera()));
  auto clip = TRY(ImageSequenceWriter::create(around.storage, options.folder, reader->camera()));
  int frames = 0;
  for (;; ++frames) {
    if (around.stop) return Error{ErrorCode::Interrupted, fmt::format("interrupted after {} frames", frames)};
    auto frame = reader->next();
    if (!frame && frame.error().code == ErrorCode::Truncated && !options.strict) {
      remark("{}; exporting these\n", frame.error().message);
      break;
    }
    if (!frame) return frame.error();
    if (!frame.value()) break;
    TRY(clip.append(**frame));
  }
  TRY(clip.finish());
  if (const std::string damage = reader->left_out().sentence(); !damage.empty())
    remark("warning: {}\n", damage);
  say("{}: {} frames\n", options.folder, frames);
  return {};
}

}  // namespace

void add_export(CLI::App& app, Verb& chosen) {
  auto options = std::make_shared<ExportOptions>();
  CLI::App* verb = app.add_subcommand("export", "turn a recording into a folder of images with a clip.json");
  verb->add_option("recording", options->recording, "the recording (.mkv)")->required();
  verb->add_option("-o,--output", options->folder, "the folder to write; it must not hold a clip yet")
      ->required();
  verb->add_flag("--strict", options->strict, "fail where the recording is cut or damaged");
  options->settings = std::make_unique<SettingsFlags>(*verb, std::vector<std::string>{"machine.memory_mib"});
  verb->callback([options, &chosen] {
    chosen = [options](Surroundings& around) { return export_recording(around, *options); };
  });
}

}  // namespace hdrcam
