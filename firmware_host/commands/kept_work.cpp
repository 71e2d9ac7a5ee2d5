#include "firmware_host/commands/kept_work.h"

#include <fmt/format.h>

#include <string_view>

#include "firmware_host/live/capture_setup.h"
#include "firmware_host/simulation/truth_folder.h"
#include "firmware_host/sinks/frame_ledger.h"
#include "firmware_host/sinks/scene_files/colmap_text.h"
#include "hal/recording/image_sequence.h"
#include "hal/video/video_writer.h"

namespace hdrcam {
namespace {

// A page or pictures that are named like one by mistake are none.
bool may_be_video(const SinkKind& sink) {
  const std::string_view name = sink.name;
  return name == "frames" || name == "video";
}

}  // namespace

void KeptWork::add_to(CommandLine verb) {
  add_without_force(verb);
  verb.add_switch("--force", force_, "replace outputs of an earlier run");
}

void KeptWork::add_without_force(CommandLine verb) { verb_ = verb; }

Result<void> KeptWork::check(Storage& storage, const std::vector<NamedInput>& inputs,
                             const std::vector<NamedOutput>& outputs) const {
  std::vector<NamedInput> read = configuration_of(*verb_);
  read.insert(read.end(), inputs.begin(), inputs.end());
  TRY(check_outputs(storage, read, outputs, force_ ? Overwrite::Force : Overwrite::Refuse));
  return make_room_for(storage, outputs);
}

std::vector<NamedOutput> outputs_of(const Settings& settings, std::span<const SinkKind> sinks) {
  std::vector<NamedOutput> outputs;
  for (const SinkKind& sink : sinks) {
    const std::string& path = settings.output.path(sink.name);
    const std::string_view flag = sink.flag;
    if (path == kStandardOutput || sink.target == SinkTarget::Address) continue;  // replaces nothing
    const std::string name(flag.substr(flag.find("--")));
    if (sink.target == SinkTarget::Model && !path.empty()) {
      for (const std::string_view file : kColmapFiles)
        outputs.push_back({name, fmt::format("{}/{}", path, file)});
      continue;
    }
    const bool video = may_be_video(sink) && video_container_of(path).has_value(),
               numbered = !video && sink.extension != nullptr;
    const OutputKind kind = video                                    ? OutputKind::Recording
                            : numbered                               ? OutputKind::Frames
                            : std::string_view(sink.name) == "sheet" ? OutputKind::Picture
                                                                     : OutputKind::Page;
    outputs.push_back({name, path, kind, numbered ? sink.extension : ""});
    if (std::string_view(sink.name) == "frames" && numbered)
      if (const auto pattern = FramePattern::parse(name, path, sink.extension))
        outputs.push_back({"the list beside --output", FrameLedger::path_beside(pattern.value())});
  }
  if (!sinks.empty())
    outputs.push_back({"--snapshot", settings.output.path(Settings::Output::kSnapshot), OutputKind::Scene});
  outputs.push_back({"--trace", settings.machine.trace});
  return outputs;
}

std::vector<NamedInput> configuration_of(CommandLine verb) {
  if (const auto file = verb.given("--config")) return {{"the configuration", *file}};
  return {};
}

std::vector<NamedInput> files_of_clip(const std::string& folder) {
  return {{"the clip", folder + "/" + ImageSequence::kFile},
          {"the pictures of the clip", folder + "/" + ImageSequence::kPictures, InputKind::Folder},
          {"the ground truth", folder + "/" + TruthFolder::kFolder, InputKind::Folder}};
}

Result<void> check_folder(Storage& storage, const std::string& path, const char* wanted) {
  if (TRY(storage.look_at(path)).kind != FileKind::Regular) return {};
  return Error{ErrorCode::Invalid, fmt::format("'{}' is a file; name {}", path, wanted)};
}

Result<void> check_clip_folder(Storage& storage, const std::string& path) {
  return check_folder(storage, path,
                      "a clip with clip.json and gt/, as 'hdrcam simulate walk --truth clips/walk' makes it");
}

std::vector<NamedInput> inputs_of(const Settings::Camera& camera) {
  if (!is_replayed(camera.id)) return {};
  return {{"the recording that is read", replayed_file(camera.id)}};
}

}  // namespace hdrcam
