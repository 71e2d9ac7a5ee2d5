// The camera side of the program, from requests to frames whose exposure is known. It keeps the camera
// supplied with requests (request_queue.h), joins each buffer with its request, report and pulses
// (frame_matcher.h), proves the exposure from the pictures (exposure_proof.h) and unpacks the pixels. It
// waits for the camera only and holds no queue of frames: a slow consumer leaves frames in the camera's
// buffers, and a camera without free buffers drops frames, which the next frame counts. Thread-bound, except
// stop(); no allocation per frame after the first.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>

#include "capture/captured_frame.h"
#include "capture/drop_streak.h"
#include "capture/exposure_adaptation.h"
#include "capture/exposure_limits.h"
#include "capture/frame_matcher.h"
#include "capture/pixel_unpack.h"
#include "capture/raw_black.h"
#include "capture/request_queue.h"
#include "capture/sensor_table.h"
#include "capture/trigger_link.h"

namespace hdrcam {

struct CaptureOptions {
  StreamMode mode{};  // wanted
  int buffers = 8;    // queued capture requests; fewer than 8 do not cover a pipeline's delay
  std::optional<ControlDelays> delays{};    // calibrated; default: the camera's or the sensor table's
  std::optional<BlackLevel> black_level{};  // the user's; default for raw: the camera's or the table's
  StrobePulse strobe = StrobePulse::Absent;
  Duration strobe_after_timestamp{0};  // of the edge that the timestamp belongs to (frame_matcher.h)
  std::optional<TimestampMark> timestamp_mark{};  // default: as the camera states it
  Adapt adapt = Adapt::Off;                       // this stage follows the light, the fit the motion
  PixelUnpackSettings unpack{};
  Duration patience{2'000'000'000};  // Timeout after this long without a frame
  // Begins each frame where the sensor waits for it; null, or outlives the stage. Something drives it
  // (trigger_thread.h); the stage starts and stops it.
  Trigger* trigger = nullptr;
  // Of the camera's timestamps: tells frames that were lost while no request was queued, whose controls stay
  // as they are, from others. Null: all requests count as queued in time; or outlives the stage.
  Clock* clock = nullptr;
};

class CaptureStage {
 public:
  // Configures the camera and checks the cycle against the capabilities that it then has. A camera that sets
  // its exposures itself (a replayed one) brings its own cycle, which replaces the given one. `strobe` may be
  // null. Errors: the camera's own, and those of ExposureSchedule::create and PulseTrain::check; Unsupported
  // for a camera that sets its exposures itself and follows no cycle, or would be triggered; Invalid for
  // control delays that are out of range. The camera, the line and this stage belong to one thread.
  static Result<std::unique_ptr<CaptureStage>> open(Camera& camera, SyncLine* strobe,
                                                    std::span<const Exposure> cycle, Mains mains,
                                                    const CaptureOptions& options);

  Result<void> start();
  // Whether the run is to end; asked every two seconds while no frame comes.
  using Ends = std::function<bool()>;
  // Writes the next frame into `frame`, whose storage is reused. Errors: the camera's own; Interrupted after
  // stop(), and where the run is to end; Invalid or Unsupported for a pixel format that cannot be unpacked,
  // Corrupt once many frames in a row were damaged or did not decode. A frame that came before the camera
  // refused the next request is delivered first.
  Result<void> next(CapturedFrame& frame, const Ends& ends = {});
  // Ends a waiting next(); may be called from any thread. start() may follow.
  Result<void> stop();
  // After stop(), on the thread of next(): counts the pulses and answers that came since the last frame.
  void settle_trigger();

  // For the recording.
  CameraFacts facts() const;
  const StreamMode& mode() const { return mode_; }
  const ExposureSchedule& schedule() const { return schedule_; }
  const CaptureCounters& counters() const { return counters_; }
  // Warnings for the user at the start; empty if there are none: an exposure that flickers under lamps, a raw
  // sensor of unknown black level, a camera whose exposures only the pictures can determine, or that has few
  // buffers.
  const std::vector<std::string>& warnings() const { return warnings_; }

  // Why no frame has an exposure, where neither camera nor pictures can tell one; empty otherwise.
  std::string exposures_account() const;

  // The schedule of another cycle. Errors: those of ExposureSchedule::create and PulseTrain::check. May be
  // called from any thread.
  Result<ExposureSchedule> schedule_of(std::span<const Exposure> cycle) const;
  // Makes later requests follow another cycle, and counts it. Errors: those of schedule_of(); after them, and
  // after what it throws, the cycle is as it was.
  Result<void> change_cycle(std::span<const Exposure> cycle);
  // What the fit may ask for; none of a camera that sets its exposures itself.
  std::optional<ExposureLimits> exposure_limits() const;
  // Takes the camera's response once the fit has estimated it; ratios then become exact (photometry.h).
  void learn_response(const PhotometricResponse::Curve& inverse, const BlackLevel& black_level);

 private:
  CaptureStage(Camera& camera, SyncLine* strobe, const CaptureOptions& options, const StreamMode& mode,
               const ExposureSchedule& schedule, Mains mains);

  FrameMatcherOptions matching() const;
  bool nobody_states_exposures() const;
  int buffers() const;  // of the camera
  int latency_frames() const;
  Duration longest_exposure() const;
  void collect_warnings();
  void restart_matching();
  Result<void> drain_strobe();
  // The camera's next buffer. Errors: the camera's own; Interrupted.
  Result<CapturedBuffer> wait(const Ends& ends);
  Result<CapturedBuffer> wait_in_parts(const Ends& ends);
  void count(const CapturedBuffer& buffer, const MatchedFrame& matched);
  // Returns whether the buffer became a frame; otherwise it was dropped and counted.
  Result<bool> take(const CapturedBuffer& buffer, CapturedFrame& frame);
  void follow_light(const CapturedFrame& frame);
  int slot_for_light(const CapturedFrame& frame) const;
  void look_at(const Image<std::uint16_t>& codes, const std::optional<BlackLevel>& black);
  void judge(const CapturedBuffer& buffer, const MatchedFrame& matched, CapturedFrame& frame);
  void set_facts(const CapturedBuffer& buffer, const MatchedFrame& matched,
                 const std::optional<BlackLevel>& black, CapturedFrame& frame);
  void set_number_and_time(const CapturedBuffer& buffer, const MatchedFrame& matched, Duration exposure,
                           FrameFacts& facts);
  int slot_of(const ExposureClaim& label) const;
  Error interrupted() const;
  Error refusal(const Error& of_request) const;

  struct Emitted {  // frame
    std::uint64_t sequence = 0, index = 0;
    Instant timestamp;
  };

  Camera& camera_;
  SyncLine* strobe_;
  CaptureOptions options_;
  StreamMode mode_;
  PixelCodes codes_;
  ExposureSchedule schedule_;
  Mains mains_;
  std::optional<KnownSensor> sensor_;
  std::vector<std::string> warnings_;

  RawBlack black_;
  Photometer photometer_;
  PhotometricSignature picture_;
  ExposureProof proof_;
  std::optional<FrameMatcher> matcher_;
  RequestQueue requests_;
  TriggerLink trigger_;
  std::optional<ExposureAdaptation> adaptation_;
  DropStreak drops_;
  int lost_since_emitted_ = 0;
  std::optional<Emitted> last_emitted_;
  Result<void> last_request_;  // the camera's answer, where it came with a frame
  std::atomic<bool> stopped_{false};
  CaptureCounters counters_;
};

}  // namespace hdrcam
