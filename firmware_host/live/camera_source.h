// A camera as the source of a run: opened, configured and put to work as the settings say, captured on a
// thread of its own (live_session.h) and recorded where a file is named. What `live` and `record` share.
// Thread-bound, but for status().
#pragma once

#include <memory>

#include "firmware_host/live/live_session.h"
#include "firmware_host/run/frame_source.h"
#include "firmware_host/settings/settings.h"
#include "hal/clock.h"
#include "hal/storage.h"

namespace hdrcam {

class CameraSource : public FrameSource {
 public:
  // Opens camera, strobe line and recording. limits: its memory is taken from the settings. Storage and stop
  // outlive the source. Errors: those of the camera, of the settings, of the disk.
  static Result<std::unique_ptr<CameraSource>> open(const Settings& settings, LiveOptions limits,
                                                    Storage& storage, const std::atomic<bool>& stop);

  const CameraFacts& camera() const override { return facts_; }
  RunPace pace() const override { return RunPace::Camera; }
  Result<void> start() override { return session_->start(); }
  Result<const RawFrame*> next() override;
  void emitted(FrameRecord& record) override;
  void learn_response(const Response::Curve& inverse, const BlackLevel& black_level) override;
  // Errors: what ended the camera or the recording. A recording that was replayed to its end is a good end.
  Result<void> finish(RunRecord& record) override;
  std::string status(const ProgressState& progress) const override;

  CaptureStage& capture() { return *capture_; }
  LiveSession& session() { return *session_; }
  // Why the run ended, once it has ended well.
  LiveEnd end() const { return end_; }

 private:
  explicit CameraSource(const std::atomic<bool>& stop) : stop_(stop) {}

  const std::atomic<bool>& stop_;
  std::unique_ptr<Camera> camera_;
  std::unique_ptr<SyncLine> strobe_;
  std::unique_ptr<CaptureStage> capture_;
  std::unique_ptr<LiveSession> session_;
  CameraFacts facts_;
  bool replayed_ = false;
  FrameShare frame_;  // the one that next() handed out
  LiveEnd end_ = LiveEnd::Frames;
  const Instant begin_ = posix_clock().now();
};

}  // namespace hdrcam
