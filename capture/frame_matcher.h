// Joins the parts of one frame: the buffer, the request that it completed, the driver's report and the strobe
// pulse during its exposure, and the trigger pulse that began it. It also determines which frames were lost.
// The result is evidence, not a verdict: exposure_proof.h judges it, and unanimous pictures feed back (learn)
// and correct the prediction.
//
//   buffers, by number and time  frame_interval.h          strobe edges   strobe_pulses.h
//   requests, by cookie          control_history.h         driven pulses  trigger_pulses.h
//                                exposure_prediction.h
//
// Three independent counts give the number of frames: the driver's sequence number, its timestamp and the
// strobe pulses. Two that agree decide. Where number and time disagree and there is no strobe, the time
// decides if it lies on the grid of the frame interval, otherwise the number (counters restart in standby and
// miss drops). A jump of more than 300 frames is no gap that a counter missed, but a clock that was set or a
// machine that slept: the number decides. A time that went back counts for nothing. With a trigger there
// is nothing to decide: each pulse that was driven is a frame. Thread-bound; bounded state, no allocation.
#pragma once

#include <optional>

#include "capture/control_history.h"
#include "capture/delayed_controls.h"
#include "capture/exposure_prediction.h"
#include "capture/exposure_proof.h"
#include "capture/exposure_schedule.h"
#include "capture/frame_interval.h"
#include "capture/strobe_pulses.h"
#include "capture/trigger_pulses.h"

namespace hdrcam {

struct FrameMatcherOptions {
  Duration frame_duration = kUsualFrameDuration;
  // Controls are written when the frame of their own request begins (hal/camera.h) and act this many frames
  // later; zero where a request sets the exposure of its own frame. nullopt: unknown, so nothing is
  // predicted.
  std::optional<ControlDelays> delays{};
  StrobePulse strobe = StrobePulse::Absent;
  // Of the rising edge, or of the falling one where the pulse spans the exposure and the timestamp marks its
  // end; depends on the wiring.
  Duration strobe_after_timestamp{0};
  TimestampMark timestamp_mark = TimestampMark::ExposureBegin;
  TriggerMode trigger = TriggerMode::Off;
};

struct MatchedFrame {
  FrameEvidence evidence;
  std::uint64_t index = 0;       // frame number at the sensor: 0 for the first, lost frames count
  int lost_before = 0;           // lost frames between the previous one and this one
  bool cookie_repeated = false;  // the request was completed before: the cookie is not usable
  Instant timestamp;             // the driver's; the strobe's where a pulse marks the frame
  TimestampMark mark = TimestampMark::ExposureBegin;
  bool strobed = false;               // a pulse of the strobe line was matched
  std::optional<Instant> opened;      // the exposure, by a strobe or trigger pulse that spans it
  std::optional<TriggerPulse> pulse;  // of the trigger line, that began the frame
  int left_out_before = 0;            // pulses that were not driven between the previous frame and this one
  bool pulse_forgotten = false;       // taken so late that its strobe or trigger pulse is not kept any more

  // The middle of an exposure of this length, of the middle row of a read-out, from the pulse where there is
  // one.
  Instant centre(Duration exposure, Duration readout) const;
};

class FrameMatcher {
 public:
  FrameMatcher(const FrameMatcherOptions& options, const ExposureSchedule& schedule);

  // The request for the next slot of the schedule. Where exposure and gain have different delays, the faster
  // control is held back for later requests (delayed_controls.h), so that both act on the same frame.
  ExposureRequest next_request();
  // When the camera took that request; where nobody says, a request counts as queued in time.
  void queued(const ExposureRequest& request, Instant at) { controls_.queued(request.cookie, at); }
  // Makes later requests follow another schedule.
  void change_schedule(const ExposureSchedule& schedule) { schedule_ = schedule; }

  // Adds an edge of the strobe line, in order.
  void strobe(const Edge& edge) { strobes_.add(edge); }
  // Adds a pulse of the trigger line, in order.
  void trigger(const TriggerPulse& pulse) { triggers_.add(pulse); }
  // Matches the next completed buffer, in order, after the edges before it.
  MatchedFrame match(const CapturedBuffer& buffer);
  // Takes the exposure (ln E) that pictures and strobe alone found for the last matched frame.
  void learn(double log_value) { prediction_.learn(controls_, log_value); }

  // The slot that was requested for the last matched frame, where its exposure is this one; -1 unknown.
  int slot_of(const ExposureClaim& label) const;
  // From frame to frame, as measured.
  Duration frame_duration() const { return interval_.value(); }
  // Frames by which the prediction is shifted so far, and how often that changed.
  int shift() const { return prediction_.shift(); }
  int relocks() const { return prediction_.relocks(); }

 private:
  struct Previous {  // buffer
    std::uint64_t sequence = 0;
    Instant timestamp;
    bool in_order = true;  // its time was later than that of the buffer before it
  };

  int frames_since(const Previous& previous, const CapturedBuffer& buffer, std::int64_t strobes,
                   int triggers) const;
  int count_frames(const CapturedBuffer& buffer, std::int64_t strobes, int triggers);
  ControlHistory::BegunSince begun_since_queued(const CapturedBuffer& buffer) const;
  std::optional<ExposureClaim> reported_in(const CapturedBuffer& buffer,
                                           const std::optional<ExposureClaim>& predicted) const;
  ExposureClaim claim_of(const TriggerPulse& pulse, const CapturedBuffer& buffer) const;
  void match_trigger(const CapturedBuffer& buffer, MatchedFrame& frame);
  void match_strobe(const StrobePulses::Pulse& pulse, MatchedFrame& frame) const;

  FrameMatcherOptions options_;
  ExposureSchedule schedule_;
  std::optional<DelayedControls> delayed_controls_;  // where exposure and gain have different delays
  std::uint64_t next_cookie_ = 0;

  ControlHistory controls_;
  ExposurePrediction prediction_;
  FrameInterval interval_;
  StrobePulses strobes_;
  TriggerPulses triggers_;

  std::optional<Previous> previous_;
  std::uint64_t index_ = 0;                 // of the last matched frame
  std::optional<ExposureClaim> triggered_;  // of that frame, where its pulse set the exposure
};

}  // namespace hdrcam
