// The camera side of the program, from requests to frames whose exposure is known: keeps the camera supplied
// with requests, joins each buffer with what belongs to it (frame_matcher.h), lets the pictures prove the
// exposure (exposure_proof.h), unpacks the pixels. It never waits for anybody but the camera, and holds no
// queue of its own: what a slow consumer leaves waiting are the camera's buffers, and a camera without free
// buffers drops frames, which the next frame counts. Thread-bound, except stop(); no allocation per frame
// after the first.
#pragma once

#include <atomic>
#include <memory>
#include <optional>

#include "capture/captured_frame.h"
#include "capture/exposure_adaptation.h"
#include "capture/frame_matcher.h"
#include "capture/pixel_unpack.h"

namespace hdrcam {

struct CaptureOptions {
  StreamMode mode{};  // wanted
  int buffers = 8;    // requests under way; fewer than 8 do not reach over a pipeline's delay
  std::optional<ControlDelays> delays{};  // calibrated; default: what the camera or the table of sensors says
  std::optional<BlackLevel> black_level{};  // as the user states it; default: the table of sensors', if raw
  StrobePulse strobe = StrobePulse::Absent;
  Duration strobe_after_timestamp{0};
  std::optional<TimestampMark> timestamp_mark{};  // default: what the camera says
  bool adapt = false;                             // the cycle follows the light (exposure_adaptation.h)
  PixelUnpackSettings unpack{};
  Duration patience{2'000'000'000};  // without a frame for so long is a Timeout
};

class CaptureStage {
 public:
  // Configures the camera and checks the cycle against what it then offers; a camera that sets its exposures
  // itself (a replayed one) has a cycle of its own, which is taken. `strobe` may be null. Errors: the
  // camera's own, and those of ExposureSchedule::create. The camera, the line and this stage belong to one
  // thread.
  static Result<std::unique_ptr<CaptureStage>> open(Camera& camera, SyncLine* strobe,
                                                    std::span<const Exposure> cycle, Mains mains,
                                                    const CaptureOptions& options);

  Result<void> start();
  // The next frame, into `frame`, whose storage is used again. Errors: the camera's own; Interrupted after
  // stop().
  Result<void> next(CapturedFrame& frame);
  // Ends a waiting next(); from any thread. start() may follow.
  Result<void> stop();

  // For the recording.
  CameraFacts facts() const;
  const StreamMode& mode() const { return mode_; }
  const ExposureSchedule& schedule() const { return schedule_; }
  const CaptureCounters& counters() const { return counters_; }
  // What the user should be told at the start, empty if nothing: an exposure that pulses under lamps, an
  // unknown sensor, no way to know exposures but by the pictures.
  const std::vector<std::string>& warnings() const { return warnings_; }

  // Requests from now on follow another cycle.
  Result<void> change_cycle(std::span<const Exposure> cycle);
  // The camera's response, once the fit has found it: ratios become exact (photometry.h).
  void learn_response(const PhotometricResponse::Curve& inverse, const BlackLevel& black_level);

 private:
  CaptureStage(Camera& camera, SyncLine* strobe, const CaptureOptions& options, const StreamMode& mode,
               const ExposureSchedule& schedule, Mains mains);

  FrameMatcherOptions matching() const;
  PhotometricResponse first_response() const;
  std::optional<BlackLevel> stated_black() const;
  bool narrow_black();
  void collect_warnings();
  void restart_matching();
  Result<void> top_up();
  Result<void> drain_strobe();
  // Whether the buffer became a frame; if not, it was dropped and counted.
  bool take(const CapturedBuffer& buffer, CapturedFrame& frame);
  void follow_light(const CapturedFrame& frame);
  void judge(const CapturedBuffer& buffer, MatchedFrame& matched, CapturedFrame& frame);
  int slot_of(const ExposureClaim& label) const;

  Camera& camera_;
  SyncLine* strobe_;
  CaptureOptions options_;
  StreamMode mode_;
  PixelCodes codes_;
  ExposureSchedule schedule_;
  Mains mains_;
  std::optional<KnownSensor> sensor_;
  std::vector<std::string> warnings_;
  std::optional<float> most_black_;  // codes of 255: what is known of a black level that nobody tells

  Photometer photometer_;
  PhotometricSignature picture_;
  ExposureProof proof_;
  std::optional<FrameMatcher> matcher_;
  std::optional<ExposureAdaptation> adaptation_;
  std::optional<ExposureRequest> pending_;  // made, but the camera had no free buffer yet
  int under_way_ = 0, depth_ = 0;           // requests with the camera now, and as many as it takes
  int lost_since_emitted_ = 0;
  CaptureCounters counters_;
};

}  // namespace hdrcam
