// The end of capture/: raw frames of one stream -> exposed frames. Exposures are relative to the stream's
// reference E_ref, the geometric mean of its cycle, so the first frames wait until that cycle is known;
// from then on each frame is handed on as it arrives. One radiance scale holds for all frames: where their
// black levels differ, exposures are those that saturate at the first stated one's. Where the response is
// unknown, the waiting frames also show which codes are white. Thread-bound; no allocation per frame after
// that.
#pragma once

#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "capture/to_exposed_frame.h"
#include "capture/white_level.h"
#include "hal/core/stage_timing.h"

namespace hdrcam {

// What becomes of a black level that the camera or the user states. Kept where the response is unknown: its
// estimate takes the codes as the camera wrote them (online/response).
enum class StatedBlack { Removed, Kept };

class ExposedStream {
 public:
  // The frame may be exchanged for another one, whose storage is then reused.
  using HandOn = std::function<Result<void>(ExposedFrame&)>;

  // first_frames: those that wait, 2 or more.
  ExposedStream(const CameraFacts& camera, int first_frames, StatedBlack stated_black);

  // Takes the next frame. Errors: BadExposure, at once even for a frame that waits; those of hand_on.
  Result<void> take(const RawFrame& raw, const HandOn& hand_on);
  // Ends the stream and hands on what waits. TooShort for fewer than two frames.
  Result<void> finish(const HandOn& hand_on);

  void set_timing(StageTiming timing) { timing_ = std::move(timing); }

 private:
  Result<void> start(const HandOn& hand_on);
  Result<void> expose(const RawFrame& raw, double interval_s);
  void remove_black(const BlackLevel& own);

  const std::size_t first_frames_;
  const StatedBlack stated_black_;
  const bool is_companded_;
  ExposedFrameSettings settings_;
  // Of frames that state none: the first that one of the waiting frames states. None: black is taken for 0.
  std::optional<BlackLevel> black_level_;
  std::optional<WhiteSearch> white_search_;  // where the response is unknown, until the first frames told
  std::vector<RawFrame> waiting_;            // until the reference is known
  bool started_ = false;
  int arrived_ = 0;
  Instant last_time_;
  ExposedFrame frame_;
  StageTiming timing_;
};

}  // namespace hdrcam
