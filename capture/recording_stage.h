// Reads a recording as a stream of frames with judged exposures; it is for a recording what CaptureStage is
// for a camera. Each frame comes once, in order, and waits for the reader; the pictures judge the exposures
// that the file states (recorded_labels.h). Thread-bound.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/captured_frame.h"
#include "capture/exposure.h"
#include "capture/recorded_labels.h"
#include "hal/recording/recording.h"

namespace hdrcam {

// What happens when frames of a recording are damaged or their pictures contradict a stated exposure: a
// warning or an error.
enum class Contradiction { Warns, Fails };

class RecordingStage {
 public:
  // Errors: those of open_recording.
  // black_level: stated by the user, instead of the recording's own.
  static Result<std::unique_ptr<RecordingStage>> open(Storage& storage, const std::string& path,
                                                      Contradiction contradiction,
                                                      const std::optional<BlackLevel>& black_level = {});
  RecordingStage(std::unique_ptr<RecordingReader> recording, Contradiction contradiction,
                 const std::optional<BlackLevel>& black_level = {});

  // The next frame; false at the end. Errors: those of RecordingReader::next, after all frames before it;
  // BadExposure for the first contradiction, where contradictions are errors.
  Result<bool> next(CapturedFrame& frame);

  const CameraFacts& camera() const { return recording_->camera(); }
  // nullopt where it is not known before the end.
  std::optional<int> frame_count() const { return recording_->frame_count(); }
  // captured = emitted + damaged.
  CaptureCounters counters() const;
  // Warnings for the user about the frames so far; empty if there are none.
  std::vector<std::string> warnings() const;

 private:
  // A frame that waits for the reader: its codes in bytes where they fit.
  class Waiting {
   public:
    explicit Waiting(CapturedFrame frame);
    CapturedFrame restored() &&;

   private:
    CapturedFrame frame_;
    Image<std::uint8_t> bytes_;  // empty where frame_ has the codes
  };

  void read_beginning();
  void count_gap(CapturedFrame& frame);
  void compare_exposure(const FrameFacts& facts);
  // Returns whether there was one more frame; end_ keeps the reason for the end.
  bool read(CapturedFrame& frame);

  std::unique_ptr<RecordingReader> recording_;
  const Contradiction contradiction_;
  const std::optional<BlackLevel> black_level_;
  RecordedLabels labels_;
  std::vector<Waiting> beginning_;  // judged together, the next one last
  bool begun_ = false;
  std::optional<Result<bool>> end_;
  CaptureCounters counters_;
  std::optional<std::uint64_t> last_sequence_;
  std::uint64_t with_exposure_ = 0;  // frames whose exposure is known
  std::optional<Exposure> first_exposure_;
  bool exposures_differ_ = false, relative_ = false;  // relative: estimated, no times
  std::uint64_t left_out_ = 0;                        // up to the frame that was read last
};

}  // namespace hdrcam
