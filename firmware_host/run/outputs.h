// Everything that a run leaves behind besides a recording: HDR frames, previews, contact sheet, statistics,
// report, each where the settings name a place for it. Thread-bound.
#pragma once

#include <memory>
#include <vector>

#include "capture/exposed_frame.h"
#include "firmware_host/settings/settings.h"
#include "firmware_host/sinks/contact_sheet.h"
#include "firmware_host/sinks/frame_sink.h"
#include "firmware_host/sinks/run_record.h"

namespace hdrcam {

class Outputs {
 public:
  // Creates the folders that are missing. The storage outlives the outputs. Errors: Invalid for a pattern or
  // a list of layers, and those of the disk.
  static Result<Outputs> open(const Settings::Output& paths, const CameraFacts& camera, Storage& storage);

  Result<void> emit(const HdrFrame& frame, const ExposedFrame& input);
  // Completes frames, previews and sheet; then conclude() writes what tells of the whole run.
  Result<void> finish();
  Result<void> conclude(const RunRecord& record);

 private:
  Outputs(const Settings::Output& paths, Storage& storage) : paths_(paths), storage_(&storage) {}

  Settings::Output paths_;
  Storage* storage_;
  std::vector<std::unique_ptr<FrameSink>> sinks_;
  std::unique_ptr<ContactSheet> sheet_;
};

}  // namespace hdrcam
