#include "firmware_host/live/camera_run.h"

#include "firmware_host/live/capture_setup.h"

namespace hdrcam {

Result<std::unique_ptr<CameraRun>> CameraRun::open(const Settings& settings, LiveOptions limits,
                                                   Storage& storage) {
  std::unique_ptr<CameraRun> run(new CameraRun);
  run->replayed_ = is_replayed(settings.camera.id);
  run->camera_ = TRY(open_camera(settings.camera.id, storage));
  run->strobe_ = TRY(open_strobe(settings.sync));
  const CaptureSetup setup = TRY(capture_setup(settings, run->camera_->capabilities()));
  run->capture_ =
      TRY(CaptureStage::open(*run->camera_, run->strobe_.get(), setup.cycle, setup.mains, setup.options));
  run->facts_ = run->capture_->facts();
  std::unique_ptr<RecordingWriter> recording;
  if (!settings.record.file.empty())
    recording = TRY(create_recording(storage, settings.record.file, run->facts_));
  limits.memory_bytes = static_cast<std::size_t>(settings.record.memory_mib) << 20;
  run->session_ = std::make_unique<LiveSession>(*run->capture_, std::move(recording), limits);
  return run;
}

Result<LiveEnd> CameraRun::finish() {
  Result<LiveEnd> end = session_->finish();
  if (replayed_ && !end && end.error().code == ErrorCode::Unplugged) return LiveEnd::Frames;
  return end;
}

}  // namespace hdrcam
