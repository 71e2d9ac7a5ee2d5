// A camera as the source of a run: opened, configured and started from the settings, captured on its own
// thread (live_session.h) and recorded where a file is named; a service manager is told how it goes. `live`
// and `record` share it. Thread-bound, except status() and what RunControl names.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "firmware_host/live/live_session.h"
#include "firmware_host/live/service_watch.h"
#include "firmware_host/live/takes.h"
#include "firmware_host/live/trigger_setup.h"
#include "firmware_host/run/frame_source.h"
#include "firmware_host/settings/settings.h"
#include "hal/clock.h"
#include "hal/storage.h"

namespace hdrcam {

class CameraSource : public FrameSource, public RunControl {
 public:
  // Opens camera, lines and recording. limits: the settings replace its memory. Storage and stop outlive the
  // source. Errors: those of the camera, of the settings, of the disk.
  static Result<std::unique_ptr<CameraSource>> open(const Settings& settings, LiveOptions limits,
                                                    Storage& storage, const std::atomic<bool>& stop);

  const CameraFacts& camera() const override { return facts_; }
  RunPace pace() const override { return RunPace::Camera; }
  Result<void> start() override;
  Result<const RawFrame*> next() override;
  Backlog backlog() const override { return session_->backlog(); }
  void emitted(FrameRecord& record) override;
  void left_out() override { session_->left_out(); }
  void learn_response(const Response::Curve& inverse, const BlackLevel& black_level) override;
  std::optional<ExposureLimits> exposure_limits() const override;
  Result<void> follow(const std::vector<Exposure>& cycle) override { return session_->follow(cycle); }
  // Errors: those that ended the camera or the recording. The end of a replayed recording is not an error.
  Result<void> finish(RunRecord& record) override;
  std::string status(const ProgressState& progress) const override;

  RunControl* control() override { return this; }
  std::vector<NamedValue> counters() const override;
  std::string recording() const override { return recording_; }
  Result<std::string> start_recording() override;
  Result<void> stop_recording() override;
  Result<void> change_cycle(const std::string& shutter, const std::string& gain) override;

  CaptureStage& capture() { return *capture_; }
  // What the user should know at the start.
  std::vector<std::string> warnings() const;
  // Once the session has ended, a sentence each where it applies: why no frame has an exposure, how the cycle
  // followed the light or the motion, how a trigger line was driven, and that the pulses of a strobe line do
  // not fit.
  std::vector<std::string> accounts() const;
  // What the camera says of its frames. The session has ended.
  std::vector<std::string> camera_warnings() const { return camera_->warnings(); }
  // The recordings that a person started, each with its frames so far, a line each; "" where none has any.
  std::string takes_account() const;
  LiveSession& session() { return *session_; }
  LiveWork work() const { return work_; }
  // Why the run ended, if it ended without an error.
  LiveEnd end() const { return end_; }

 private:
  CameraSource(const Settings& settings, const std::atomic<bool>& stop)
      : stop_(stop),
        adapt_(settings.schedule.adapt),
        gain_(settings.schedule.gain),
        own_recording_(settings.record.file),
        recording_(own_recording_) {}

  std::string adaptation_account() const;  // "" where the cycle follows neither light nor motion

  const std::atomic<bool>& stop_;
  std::unique_ptr<CameraLines> lines_;
  std::unique_ptr<Camera> camera_;
  std::unique_ptr<CaptureStage> capture_;
  std::unique_ptr<LiveSession> session_;
  std::optional<ServiceWatch> watch_;
  CameraFacts facts_;
  std::vector<std::string> differences_;  // from what was asked of the camera
  LiveWork work_ = LiveWork::Fit;
  bool replayed_ = false;
  bool exposure_fixed_ = false;  // by the camera
  const Adapt adapt_;
  std::string gain_;                 // of the cycle, as --gain is written
  const std::string own_recording_;  // the file that the settings name; "" for none
  std::string recording_;            // the file that is open; "" for none
  std::optional<Takes> takes_;       // recordings that a person starts; none where the user named no place
  FrameShare frame_;                 // the one that next() returned
  LiveEnd end_ = LiveEnd::Frames;
  const Instant begin_ = posix_clock().now();
};

}  // namespace hdrcam
