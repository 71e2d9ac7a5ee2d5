#include "firmware_host/commands/run_files.h"

#include <fmt/format.h>

#include <string_view>
#include <utility>

#include "firmware_host/live/capture_setup.h"
#include "firmware_host/simulation/truth_folder.h"
#include "firmware_host/sinks/frame_ledger.h"
#include "firmware_host/sinks/frame_pattern.h"
#include "firmware_host/sinks/scene_files/colmap_text.h"
#include "firmware_host/sinks/sink_name.h"
#include "hal/recording/image_sequence.h"
#include "hal/video/video_writer.h"

namespace hdrcam {
namespace {

// "-o,--output" by its long name.
std::string long_flag_of(const SinkKind& sink) {
  const std::string_view flags = sink.flag;
  return std::string(flags.substr(flags.find("--")));
}

// A page or pictures that are named like one by mistake are none.
bool is_video(const SinkKind& sink, const std::string& path) {
  return (sink.name == sink_name::kFrames || sink.name == sink_name::kVideo) &&
         video_container_of(path).has_value();
}

NamedOutput file_of(const SinkKind& sink, const std::string& path) {
  const std::string flag = long_flag_of(sink);
  if (is_video(sink, path)) return {flag, path, OutputKind::Recording};
  if (sink.extension != nullptr) return {flag, path, OutputKind::Frames, sink.extension};
  if (sink.name == sink_name::kTransforms) return {flag, path, OutputKind::Poses};
  const bool picture = sink.name == sink_name::kSheet;
  return {flag, path, picture ? OutputKind::Picture : OutputKind::Page};
}

std::vector<NamedOutput> files_of_model(const SinkKind& sink, const std::string& folder) {
  std::vector<NamedOutput> files;
  for (const std::string_view file : kColmapFiles)
    files.push_back({long_flag_of(sink), fmt::format("{}/{}", folder, file), OutputKind::Poses});
  return files;
}

// All that a sink writes there.
std::vector<NamedOutput> files_of(const SinkKind& sink, const std::string& path) {
  if (path.empty() || path == kStandardOutput || sink.target == SinkTarget::Address)
    return {};  // replaces nothing
  if (sink.target == SinkTarget::Model) return files_of_model(sink, path);
  std::vector<NamedOutput> files{file_of(sink, path)};
  if (sink.name == sink_name::kFrames && files.front().kind == OutputKind::Frames)
    if (const auto pattern = FramePattern::parse(files.front().flag, path, sink.extension))
      files.push_back(
          {"the list beside --output", FrameLedger::path_beside(pattern.value()), OutputKind::List});
  return files;
}

}  // namespace

std::vector<NamedOutput> outputs_of(const Settings& settings, std::span<const SinkKind> sinks) {
  std::vector<NamedOutput> outputs;
  for (const SinkKind& sink : sinks)
    for (NamedOutput& file : files_of(sink, settings.output.path(sink.name)))
      outputs.push_back(std::move(file));
  if (!sinks.empty())
    outputs.push_back({"--snapshot", settings.output.path(Settings::Output::kSnapshot), OutputKind::Scene});
  outputs.push_back({"--trace", settings.machine.trace});
  return outputs;
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
  return {{"the file that is read", replayed_file(camera.id)}};
}

}  // namespace hdrcam
