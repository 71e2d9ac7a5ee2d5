#include "firmware_host/commands/kept_work.h"

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string_view>

#include "firmware_host/sinks/frame_ledger.h"
#include "firmware_host/sinks/scene_files/colmap_text.h"
#include "firmware_host/sinks/sink_table.h"
#include "hal/video/video_writer.h"

namespace hdrcam {

void KeptWork::add_to(CLI::App& verb) {
  verb.add_flag("--force", force_, "replace outputs of an earlier run");
}

Result<void> KeptWork::check(Storage& storage, const std::vector<NamedInput>& inputs,
                             const std::vector<NamedOutput>& outputs) const {
  TRY(check_outputs(storage, inputs, outputs, force_ ? Overwrite::Force : Overwrite::Refuse));
  return make_room_for(storage, outputs);
}

std::vector<NamedOutput> outputs_of(const Settings& settings, const char* recording_flag) {
  std::vector<NamedOutput> outputs;
  for (const SinkKind& sink : sink_kinds()) {
    const std::string& path = settings.output.path(sink.name);
    const std::string_view flag = sink.flag;
    if (path == kStandardOutput || sink.target == SinkTarget::Address) continue;  // replaces nothing
    const std::string name(flag.substr(flag.find("--")));
    if (sink.target == SinkTarget::Model && !path.empty()) {
      for (const std::string_view file : kColmapFiles)
        outputs.push_back({name, fmt::format("{}/{}", path, file)});
      continue;
    }
    const OutputKind kind = path.find('%') != std::string::npos ? OutputKind::Frames
                            : video_container_of(path)          ? OutputKind::Recording
                                                                : OutputKind::Page;
    outputs.push_back({name, path, kind});
    if (std::string_view(sink.name) == "frames" && kind == OutputKind::Frames)
      outputs.push_back({"the list beside --output",
                         (std::filesystem::path(path).parent_path() / FrameLedger::kFile).string()});
  }
  outputs.push_back({"--trace", settings.machine.trace});
  outputs.push_back({recording_flag, settings.record.file, OutputKind::Recording});
  return outputs;
}

std::vector<NamedInput> inputs_of(const Settings::Camera& camera) {
  constexpr std::string_view kReplay = "replay:";
  if (!camera.id.starts_with(kReplay)) return {};
  return {{"the recording that is read", camera.id.substr(kReplay.size())}};
}

}  // namespace hdrcam
