#include "capture/frame_matcher.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hdrcam {

Instant MatchedFrame::centre(Duration exposure, Duration readout) const {
  const Duration half = (exposure + readout) / 2;
  if (opened) return *opened + half;
  return timestamp + (mark == TimestampMark::ExposureBegin ? half : -half);
}

FrameMatcher::FrameMatcher(const FrameMatcherOptions& options, const ExposureSchedule& schedule)
    : options_(options),
      schedule_(schedule),
      prediction_(options.delays),
      interval_(options.frame_duration),
      strobes_(options.strobe, options.strobe_after_timestamp, options.timestamp_mark),
      triggers_(options.trigger, options.timestamp_mark, options.frame_duration) {
  if (!options_.delays || options_.delays->exposure == options_.delays->gain) return;
  const Exposure& first = schedule_.exposure_of(0);
  delayed_controls_.emplace(*options_.delays, ExposureRequest{0, first.time, first.gain});
}

ExposureRequest FrameMatcher::next_request() {
  const std::uint64_t cookie = next_cookie_++;
  const Exposure& exposure = schedule_.exposure_of(cookie);
  ExposureRequest request{cookie, exposure.time, exposure.gain};
  if (delayed_controls_) request = delayed_controls_->held_back(request);
  controls_.sent(request, schedule_.slot_of(cookie));
  return request;
}

// Frames of the sensor between the previous buffer and this one; at least one. A trigger pulse that it did
// not answer began no frame, so no controls acted at it.
int FrameMatcher::frames_since(const Previous& previous, const CapturedBuffer& buffer, std::int64_t strobes,
                               int triggers) const {
  // Of 29.97 Hz for 30 the grid is .3 frames off after that many: of a longer gap it tells nothing.
  constexpr double kOffGrid = 0.3, kFurthestOnGrid = 300, kLongest = 1e6;  // frames
  const double by_number =
      buffer.sequence > previous.sequence ? static_cast<double>(buffer.sequence - previous.sequence) : 0;
  if (triggers > 0) return std::clamp(static_cast<int>(std::min(by_number, kLongest)), 1, triggers);
  const double elapsed = interval_.frames_in(buffer.timestamp - previous.timestamp);
  const double by_time = std::round(elapsed);
  const bool on_grid = interval_.measured() && previous.in_order && by_time >= 1 &&
                       by_time <= kFurthestOnGrid && std::abs(elapsed - by_time) <= kOffGrid;
  const auto by_strobe = static_cast<double>(strobes);
  const bool strobe_agrees = by_strobe >= 1 && (by_strobe == by_number || by_strobe == by_time);
  const double frames = strobe_agrees ? by_strobe : on_grid ? by_time : by_number;
  return static_cast<int>(std::clamp(frames, 1.0, kLongest));
}

// The same, 0 for the first buffer, which becomes the previous one.
int FrameMatcher::count_frames(const CapturedBuffer& buffer, std::int64_t strobes, int triggers) {
  const bool in_order = !previous_ || buffer.timestamp > previous_->timestamp;
  const auto previous = std::exchange(previous_, Previous{buffer.sequence, buffer.timestamp, in_order});
  if (!previous) return 0;
  const int frames = frames_since(*previous, buffer, strobes, triggers);
  if (buffer.sequence > previous->sequence && in_order && previous->in_order)
    interval_.observe(buffer.sequence - previous->sequence, buffer.timestamp - previous->timestamp);
  return frames;
}

// A program that was held up queues no requests, and the sensor goes on with what was written last.
ControlHistory::BegunSince FrameMatcher::begun_since_queued(const CapturedBuffer& buffer) const {
  constexpr double kUnsure = 0.4;  // of an interval, between the begin of a frame and its timestamp
  const auto queued = controls_.queued_at(buffer.cookie);
  if (!queued) return {};
  const double before = interval_.frames_in(buffer.timestamp - *queued);
  const auto begun = [](double frames) {
    constexpr double kMost = ControlHistory::kFrames;
    return 1 + static_cast<std::uint64_t>(std::clamp(frames, 0.0, kMost));
  };
  return {begun(before - kUnsure), begun(before + kUnsure)};
}

// The driver's report for this frame. A report without gain takes the gain from the prediction, or from a
// schedule that has only one gain.
std::optional<ExposureClaim> FrameMatcher::reported_in(const CapturedBuffer& buffer,
                                                       const std::optional<ExposureClaim>& predicted) const {
  if (!buffer.exposure || *buffer.exposure <= Duration(0)) return std::nullopt;
  std::optional<double> gain = buffer.analogue_gain;
  if (!gain && predicted) gain = predicted->exposure.gain;
  if (!gain) {
    const ExposureSchedule::Cycle cycle = schedule_.cycle();
    gain = cycle.front().gain;
    for (const Exposure& exposure : cycle)
      if (exposure.gain != *gain) return std::nullopt;
  }
  const double digital = buffer.digital_gain.value_or(1);
  if (!(*gain > 0) || !(digital > 0)) return std::nullopt;
  return ExposureClaim{
      {*buffer.exposure, *gain}, digital, buffer.exposure_source.value_or(ExposureSource::Reported)};
}

// The camera's own report is what its controls were set to: in external trigger mode not the exposure.
ExposureClaim FrameMatcher::claim_of(const TriggerPulse& pulse, const CapturedBuffer& buffer) const {
  const double gain = buffer.analogue_gain.value_or(schedule_.slot(0).exposure.gain);
  return {{pulse.width(), gain}, buffer.digital_gain.value_or(1), ExposureSource::Reported};
}

void FrameMatcher::match_trigger(const CapturedBuffer& buffer, MatchedFrame& frame) {
  frame.left_out_before = triggers_.left_out_since_last(frame.pulse);
  triggers_.matched(frame.pulse);
  triggered_.reset();
  if (!frame.pulse || options_.trigger != TriggerMode::PulseWidth) return;
  triggered_ = claim_of(*frame.pulse, buffer);
  frame.opened = frame.pulse->rise.at;
  frame.evidence.claims.push_back(*triggered_);
  frame.evidence.pulse_within = frame.pulse->width_within();
}

MatchedFrame FrameMatcher::match(const CapturedBuffer& buffer) {
  MatchedFrame frame;
  frame.timestamp = buffer.timestamp;
  frame.mark = options_.timestamp_mark;

  const auto strobe = strobes_.pulse_of(buffer.timestamp, interval_.value() / 4);
  frame.pulse = triggers_.pulse_of(buffer.timestamp);
  frame.pulse_forgotten =
      (!strobe && strobes_.forgot(buffer.timestamp)) || (!frame.pulse && triggers_.forgot(buffer.timestamp));
  const int triggers = triggers_.since_last(frame.pulse);
  const int frames = count_frames(buffer, strobes_.since_last(strobe), triggers);
  strobes_.matched(strobe);
  frame.lost_before = std::max(0, (triggers > 0 ? triggers : frames) - 1);
  index_ += static_cast<std::uint64_t>(frames);
  frame.index = index_;
  match_trigger(buffer, frame);

  frame.cookie_repeated =
      !controls_.completed(index_, buffer.cookie, buffer.control_late, begun_since_queued(buffer));
  const auto predicted = prediction_.predict(controls_);
  const auto reported = reported_in(buffer, predicted);
  if (reported && options_.trigger != TriggerMode::PulseWidth) frame.evidence.claims.push_back(*reported);
  if (predicted) frame.evidence.claims.push_back(*predicted);
  frame.evidence.prediction_doubtful = predicted && prediction_.doubtful(controls_);
  if (strobe) match_strobe(*strobe, frame);
  return frame;
}

// The kernel stamps the edge in its interrupt handler; the driver's timestamp may be later.
void FrameMatcher::match_strobe(const StrobePulses::Pulse& pulse, MatchedFrame& frame) const {
  frame.strobed = true;
  if (options_.strobe == StrobePulse::MarksFrame) {
    frame.timestamp = pulse.rise + -options_.strobe_after_timestamp;
  } else {
    frame.opened = pulse.rise;
    frame.evidence.strobe_width = pulse.width;
  }
}

int FrameMatcher::slot_of(const ExposureClaim& label) const {
  const auto is_label = [value = label.log_value()](double log_value) {
    return same_exposure(log_value, value);
  };
  const auto has_label = [&](int slot) { return is_label(log_product(schedule_.slot(slot).exposure)); };
  if (const auto& pulse = triggers_.last(); triggered_ && pulse->planned.slot < schedule_.slots())
    if (is_label(triggered_->log_value())) return pulse->late ? -1 : pulse->planned.slot;
  if (const ControlHistory::Request* request = prediction_.shown(controls_); request != nullptr)
    if (request->slot < schedule_.slots() && has_label(request->slot)) return request->slot;
  int slot = -1;
  for (int i = 0; i < schedule_.slots(); ++i) {
    if (!has_label(i)) continue;
    if (slot >= 0) return -1;  // two slots have this exposure
    slot = i;
  }
  return slot;
}

}  // namespace hdrcam
