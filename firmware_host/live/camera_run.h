// A camera opened, configured and put to work as the settings say: what `live` and `record` share.
// Thread-bound.
#pragma once

#include <memory>

#include "firmware_host/live/live_session.h"
#include "firmware_host/settings/settings.h"
#include "hal/storage.h"

namespace hdrcam {

class CameraRun {
 public:
  // Opens camera, strobe line and recording. limits: its memory is taken from the settings. The storage
  // outlives the run. Errors: those of the camera, of the settings, of the disk.
  static Result<std::unique_ptr<CameraRun>> open(const Settings& settings, LiveOptions limits,
                                                 Storage& storage);

  CaptureStage& capture() { return *capture_; }
  LiveSession& session() { return *session_; }
  const CameraFacts& facts() const { return facts_; }
  // Session's finish(), where a recording that was replayed to its end is a good end too.
  Result<LiveEnd> finish();

 private:
  CameraRun() = default;

  std::unique_ptr<Camera> camera_;
  std::unique_ptr<SyncLine> strobe_;
  std::unique_ptr<CaptureStage> capture_;
  std::unique_ptr<LiveSession> session_;
  CameraFacts facts_;
  bool replayed_ = false;
};

}  // namespace hdrcam
