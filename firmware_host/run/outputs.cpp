#include "firmware_host/run/outputs.h"

#include <filesystem>

#include "firmware_host/sinks/exr_sequence.h"
#include "firmware_host/sinks/preview.h"
#include "firmware_host/sinks/report.h"

namespace hdrcam {
namespace {

Result<void> make_folder_of(Storage& storage, const std::string& path) {
  const auto folder = std::filesystem::path(path).parent_path();
  if (path.empty() || folder.empty()) return {};
  return storage.make_directories(folder.string());
}

}  // namespace

Result<Outputs> Outputs::open(const Settings::Output& paths, const CameraFacts& camera, Storage& storage) {
  for (const std::string* path : {&paths.stats, &paths.report, &paths.sheet})
    TRY(make_folder_of(storage, *path));
  Outputs outputs(paths, storage);
  if (!paths.frames.empty()) {
    ExrSequenceOptions options;
    options.layers = TRY(parse_layers(paths.layers));
    options.compression = paths.compression == "piz" ? ExrCompression::Piz : ExrCompression::Zip;
    options.framerate_hz = camera.framerate_hz;
    outputs.sinks_.push_back(TRY(create_exr_sequence(storage, paths.frames, options)));
  }
  if (!paths.preview.empty()) outputs.sinks_.push_back(TRY(create_preview(storage, paths.preview)));
  if (!paths.sheet.empty() || !paths.report.empty())
    outputs.sheet_ = std::make_unique<ContactSheet>(storage, paths.sheet);
  return outputs;
}

Result<void> Outputs::emit(const HdrFrame& frame, const ExposedFrame& input) {
  if (sheet_) {
    sheet_->saw_input(input.facts, input.codes);
    TRY(sheet_->emit(frame));
  }
  for (auto& sink : sinks_) TRY(sink->emit(frame));
  return {};
}

Result<void> Outputs::finish() {
  if (sheet_) TRY(sheet_->finish());
  for (auto& sink : sinks_) TRY(sink->finish());
  return {};
}

Result<void> Outputs::conclude(const RunRecord& record) {
  if (!paths_.stats.empty()) TRY(write_stats(*storage_, paths_.stats, record));
  if (!paths_.report.empty()) TRY(write_report(*storage_, paths_.report, record, sheet_->png()));
  return {};
}

}  // namespace hdrcam
