// A recording as the source of a run: every frame, as fast as the fit takes them, with its exposure judged by
// the pictures (capture/recording_stage.h). `replay` and a camera that replays a recording share it and
// therefore give the same bytes. Thread-bound.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/recording_stage.h"
#include "firmware_host/run/frame_source.h"
#include "hal/clock.h"
#include "hal/storage.h"

namespace hdrcam {

struct RecordingSourceOptions {
  int frames = 0;       // at most this many, 0 for all
  Duration timeout{0};  // of the run, 0 for none
  Contradiction contradiction = Contradiction::Warns;
  std::optional<BlackLevel> black_level = {};  // stated by the user, instead of the recording's own
  std::string copy_to = {};                    // a recording of the judged frames; "" for none
  RecordingCodec copy_codec = RecordingCodec::Huffyuv;
};

class RecordingSource : public FrameSource {
 public:
  // stop: becomes true when the user asks to stop; the run then ends with Interrupted, its frames complete.
  // Storage and stop outlive the source. Errors: those of open_recording and, for a copy, of
  // create_recording.
  static Result<std::unique_ptr<RecordingSource>> open(Storage& storage, const std::string& path,
                                                       const RecordingSourceOptions& options,
                                                       const std::atomic<bool>& stop);

  // The same of frames from elsewhere, such as a clip of images.
  static std::unique_ptr<RecordingSource> of(std::unique_ptr<RecordingReader> frames,
                                             const RecordingSourceOptions& options,
                                             const std::atomic<bool>& stop);

  ~RecordingSource() override;  // completes the copy, also of a run that threw
  RecordingSource(const RecordingSource&) = delete;
  RecordingSource& operator=(const RecordingSource&) = delete;

  const CameraFacts& camera() const override { return recording_->camera(); }
  RunPace pace() const override { return RunPace::Clip; }
  std::optional<int> frame_count() const override;
  Result<const RawFrame*> next() override;
  void left_out() override { ++left_out_; }
  Result<void> finish(RunRecord& record) override;

  // Whether the time was up before the recording's end.
  bool timed_out() const { return timed_out_; }
  // Warnings for the user about the frames so far.
  std::vector<std::string> warnings() const;
  CaptureCounters counters() const { return recording_->counters(); }

 private:
  RecordingSource(std::string path, std::unique_ptr<RecordingStage> recording,
                  std::unique_ptr<RecordingWriter> copy, const RecordingSourceOptions& options,
                  const std::atomic<bool>& stop)
      : path_(std::move(path)),
        recording_(std::move(recording)),
        copy_(std::move(copy)),
        options_(options),
        stop_(stop) {}
  Result<void> or_cut(Result<void> wrote) const;

  const std::string path_;  // of the recording; "" for frames from elsewhere, which no cut ends
  const std::unique_ptr<RecordingStage> recording_;
  const std::unique_ptr<RecordingWriter> copy_;
  const RecordingSourceOptions options_;
  const std::atomic<bool>& stop_;
  const Instant begin_ = posix_clock().now();
  CapturedFrame frame_;
  int read_ = 0;
  int kept_out_ = 0;  // of those, for their exposures
  int left_out_ = 0;  // of those, not emitted to hold the deadline
  bool timed_out_ = false;
  Result<void> end_;
};

}  // namespace hdrcam
