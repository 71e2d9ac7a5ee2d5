// Joins the parts of one frame: the buffer, the request that it completed, the driver's report and
// the strobe pulse during its exposure, and the trigger pulse that began it. It also determines which frames
// were lost. The result is evidence, not a verdict: exposure_proof.h judges it, and unanimous pictures feed
// back (learn) and correct the prediction, so that a missed frame start or a wrong delay is corrected within
// a cycle.
//
// Three independent counts give the number of frames: the driver's sequence number, its timestamp and the
// strobe pulses. Two that agree decide. Where number and time disagree and there is no strobe, the time
// decides if it lies on the grid of the frame duration, otherwise the number (counters restart in standby and
// miss drops). The frame duration is measured: not every camera keeps the one that it agreed to. With a
// trigger there is nothing to decide: each pulse that was driven is a frame.
// Thread-bound; bounded state, no allocation.
#pragma once

#include <array>
#include <optional>

#include "capture/control_delay.h"
#include "capture/exposure_proof.h"
#include "capture/exposure_schedule.h"
#include "capture/frame_interval.h"
#include "capture/strobe_pulses.h"
#include "capture/trigger_pulses.h"

namespace hdrcam {

struct FrameMatcherOptions {
  Duration frame_duration{33'333'333};
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

  // The middle of an exposure of this length, of the middle row of a read-out, from the pulse where there is
  // one.
  Instant centre(Duration exposure, Duration readout) const;
};

class FrameMatcher {
 public:
  FrameMatcher(const FrameMatcherOptions& options, const ExposureSchedule& schedule);

  // The request for the next slot of the schedule. Where exposure and gain have different delays, the faster
  // control is held back for later requests (control_delay.h), so that both act on the same frame.
  ExposureRequest next_request();
  // Makes later requests follow another schedule.
  void change_schedule(const ExposureSchedule& schedule) { schedule_ = schedule; }

  // Adds an edge of the strobe line, in order.
  void strobe(const Edge& edge) { strobes_.add(edge); }
  // Adds a pulse of the trigger line, in order.
  void trigger(const TriggerPulse& pulse) { triggers_.add(pulse); }
  // Matches the next completed buffer, in order, after the edges before it.
  MatchedFrame match(const CapturedBuffer& buffer);
  // Takes the exposure (ln E) that pictures and strobe alone found for the last matched frame.
  void learn(double log_value);

  // The slot that was requested for the last matched frame, where its exposure is this one; -1
  // unknown.
  int slot_of(const ExposureClaim& label) const;
  // From frame to frame, as measured.
  Duration frame_duration() const { return interval_.value(); }
  // Frames by which the prediction is shifted so far, and how often that changed.
  int shift() const { return shift_; }
  int relocks() const { return relocks_; }

 private:
  static constexpr int kRequests = 64, kFrames = 32, kObservations = 3, kMaxShift = 4;

  struct SentRequest {
    ExposureRequest request;  // as it was queued
    int slot = -1;            // its slot, though part of it may be held back
    bool valid = false;
    bool late = false;  // its controls were written late
  };
  struct Observation {
    std::uint64_t index = 0;
    double log_value = 0;
  };

  int frames_since_last(const CapturedBuffer& buffer, std::int64_t strobes, int triggers) const;
  void note_turns(std::uint64_t cookie, bool repeated, int advance);
  std::optional<ExposureClaim> reported_in(const CapturedBuffer& buffer,
                                           const std::optional<ExposureClaim>& predicted) const;
  std::optional<ExposureClaim> predicted_for(std::uint64_t index, int shift) const;
  const SentRequest* written_at(std::int64_t index) const;
  bool may_show_earlier(std::uint64_t index) const;
  void match_strobe(const StrobePulses::Pulse& pulse, MatchedFrame& frame) const;
  void match_trigger(const CapturedBuffer& buffer, MatchedFrame& frame);
  ExposureClaim claim_of(const TriggerPulse& pulse, const CapturedBuffer& buffer) const;
  bool explains(int shift) const;

  FrameMatcherOptions options_;
  ExposureSchedule schedule_;
  std::optional<ControlDelay> delay_model_;
  std::array<SentRequest, kRequests> sent_{};  // by cookie
  std::uint64_t next_cookie_ = 0;

  bool started_ = false;
  std::uint64_t sequence_ = 0, index_ = 0, highest_cookie_ = 0;
  Instant timestamp_;
  FrameInterval interval_;
  // By frame: the cookie of the request whose controls were written when it began.
  std::array<std::optional<std::uint64_t>, kFrames> turn_{};

  StrobePulses strobes_;
  TriggerPulses triggers_;
  std::optional<ExposureClaim> triggered_;  // of the last matched frame, where its pulse set the exposure

  std::array<Observation, kObservations> observations_{};
  int observation_count_ = 0, shift_ = 0, relocks_ = 0;
};

}  // namespace hdrcam
