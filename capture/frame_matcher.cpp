#include "capture/frame_matcher.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace hdrcam {
namespace {

bool same(double a, double b) { return std::abs(a - b) <= kSameExposure; }

}  // namespace

Instant MatchedFrame::centre(Duration exposure, Duration readout) const {
  const Duration half = (exposure + readout) / 2;
  if (opened) return *opened + half;
  return timestamp + (mark == TimestampMark::ExposureBegin ? half : -half);
}

FrameMatcher::FrameMatcher(const FrameMatcherOptions& options, const ExposureSchedule& schedule)
    : options_(options),
      schedule_(schedule),
      interval_(options.frame_duration),
      strobes_(options.strobe, options.strobe_after_timestamp, options.timestamp_mark),
      triggers_(options.trigger, options.timestamp_mark, options.frame_duration) {
  if (!options_.delays || options_.delays->exposure == options_.delays->gain) return;
  const Exposure& first = schedule_.exposure_of(0);
  const SensorDelays delays{options_.delays->exposure, options_.delays->gain, 0};
  delay_model_.emplace(delays, ExposureRequest{0, first.time, first.gain}, options_.frame_duration);
}

ExposureRequest FrameMatcher::next_request() {
  const std::uint64_t cookie = next_cookie_++;
  const Exposure& exposure = schedule_.exposure_of(cookie);
  ExposureRequest request{cookie, exposure.time, exposure.gain};
  if (delay_model_) {
    delay_model_->push(request, options_.frame_duration);
    const ControlDelay::Writes writes = delay_model_->frame_started(cookie);
    request = {cookie, writes.exposure, writes.analogue_gain};
  }
  sent_[cookie % kRequests] = {request, schedule_.slot_of(cookie), true, false};
  return request;
}

// Frames of the sensor between the buffer before and this one; at least one. A trigger pulse that the sensor
// did not answer is no frame of its, so its controls did not act meanwhile.
int FrameMatcher::frames_since_last(const CapturedBuffer& buffer, std::int64_t strobes, int triggers) const {
  constexpr double kOffGrid = 0.3, kLongest = 1e6;
  const double by_number = buffer.sequence > sequence_ ? static_cast<double>(buffer.sequence - sequence_) : 0;
  if (triggers > 0) return std::clamp(static_cast<int>(std::min(by_number, kLongest)), 1, triggers);
  const double elapsed = interval_.frames_in(buffer.timestamp - timestamp_);
  const double by_time = std::round(elapsed);
  const bool on_grid = interval_.measured() && by_time >= 1 && std::abs(elapsed - by_time) <= kOffGrid;
  const auto by_strobe = static_cast<double>(strobes);
  const bool strobe_agrees = by_strobe >= 1 && (by_strobe == by_number || by_strobe == by_time);
  const double frames = strobe_agrees ? by_strobe : on_grid ? by_time : by_number;
  return static_cast<int>(std::clamp(frames, 1.0, kLongest));
}

// The completed request was due when the frame after the previous one began, and stayed due while frames were
// lost.
void FrameMatcher::note_turns(std::uint64_t cookie, bool repeated, int advance) {
  for (std::uint64_t back = 0; back < static_cast<std::uint64_t>(std::clamp(advance, 1, int{kFrames}));
       ++back)
    turn_[(index_ - back) % kFrames] = repeated ? std::nullopt : std::optional(cookie);
}

// The request whose controls were written when that frame began; null where it is unknown.
const FrameMatcher::SentRequest* FrameMatcher::written_at(std::int64_t index) const {
  const auto newest = static_cast<std::int64_t>(index_);
  if (index < 0 || newest - index >= kFrames) return nullptr;
  const auto& turn = turn_[static_cast<std::uint64_t>(std::min(index, newest)) % kFrames];
  if (!turn) return nullptr;
  const std::uint64_t cookie = *turn + static_cast<std::uint64_t>(std::max<std::int64_t>(0, index - newest));
  const SentRequest& sent = sent_[cookie % kRequests];
  return sent.valid && sent.request.cookie == cookie ? &sent : nullptr;
}

std::optional<ExposureClaim> FrameMatcher::predicted_for(std::uint64_t index, int shift) const {
  if (!options_.delays) return std::nullopt;
  const std::int64_t frame = static_cast<std::int64_t>(index) + shift;
  const SentRequest* time = written_at(frame - options_.delays->exposure);
  const SentRequest* gain = written_at(frame - options_.delays->gain);
  if (time == nullptr || gain == nullptr) return std::nullopt;
  return ExposureClaim{{time->request.exposure, gain->request.analogue_gain}, 1, ExposureSource::Predicted};
}

// Whether the controls behind the prediction were written so late that the frame may show others.
bool FrameMatcher::may_show_earlier(std::uint64_t index) const {
  const auto changed_late = [&](int delay, auto&& value) {
    const std::int64_t frame = static_cast<std::int64_t>(index) + shift_ - delay;
    const SentRequest* sent = written_at(frame);
    for (int back = 1; sent != nullptr && sent->late && back <= kMaxShift; ++back) {
      const SentRequest* before = written_at(frame - back);
      if (before == nullptr || value(*before) != value(*sent)) return true;
      sent = before;
    }
    return false;
  };
  return changed_late(options_.delays->exposure,
                      [](const SentRequest& sent) { return sent.request.exposure; }) ||
         changed_late(options_.delays->gain,
                      [](const SentRequest& sent) { return sent.request.analogue_gain; });
}

// The driver's report for this frame. A report without gain takes the gain from the prediction, or from a
// schedule that has only one gain.
std::optional<ExposureClaim> FrameMatcher::reported_in(const CapturedBuffer& buffer,
                                                       const std::optional<ExposureClaim>& predicted) const {
  if (!buffer.exposure || *buffer.exposure <= Duration(0)) return std::nullopt;
  std::optional<double> gain = buffer.analogue_gain;
  if (!gain && predicted) gain = predicted->exposure.gain;
  if (!gain) {
    gain = schedule_.slot(0).exposure.gain;
    for (int i = 1; i < schedule_.slots(); ++i)
      if (schedule_.slot(i).exposure.gain != *gain) return std::nullopt;
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
  frame.evidence.add(*triggered_);
  frame.evidence.pulse_within = frame.pulse->width_within();
}

MatchedFrame FrameMatcher::match(const CapturedBuffer& buffer) {
  MatchedFrame frame;
  const auto strobe = strobes_.pulse_of(buffer.timestamp, interval_.value() / 4);
  frame.pulse = triggers_.pulse_of(buffer.timestamp);
  const int pulses = triggers_.since_last(frame.pulse);
  const int advance = started_ ? frames_since_last(buffer, strobes_.since_last(strobe), pulses) : 0;
  if (started_ && buffer.sequence > sequence_ && buffer.timestamp > timestamp_)
    interval_.observe(buffer.sequence - sequence_, buffer.timestamp - timestamp_);
  match_trigger(buffer, frame);
  frame.lost_before = std::max(0, (pulses > 0 ? pulses : advance) - 1);
  frame.cookie_repeated = started_ && buffer.cookie <= highest_cookie_;
  index_ += static_cast<std::uint64_t>(advance);
  frame.index = index_;
  frame.timestamp = buffer.timestamp;
  frame.mark = options_.timestamp_mark;
  sequence_ = buffer.sequence;
  timestamp_ = buffer.timestamp;
  strobes_.matched(strobe);
  highest_cookie_ = started_ ? std::max(highest_cookie_, buffer.cookie) : buffer.cookie;
  started_ = true;

  if (SentRequest& sent = sent_[buffer.cookie % kRequests]; sent.request.cookie == buffer.cookie)
    sent.late = buffer.control_late;
  note_turns(buffer.cookie, frame.cookie_repeated, advance);
  const auto predicted = predicted_for(index_, shift_);
  const auto reported = reported_in(buffer, predicted);
  if (reported && options_.trigger != TriggerMode::PulseWidth) frame.evidence.add(*reported);
  if (predicted) frame.evidence.add(*predicted);
  frame.evidence.prediction_doubtful = predicted && may_show_earlier(index_);
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

bool FrameMatcher::explains(int shift) const {
  return std::all_of(observations_.begin(), observations_.end(), [&](const Observation& observation) {
    const auto predicted = predicted_for(observation.index, shift);
    return predicted && same(predicted->log_value(), observation.log_value);
  });
}

// Shifts the prediction when the last frames, with at least two different exposures, all show it late or
// early by the same number of frames. A single late frame does not shift it.
void FrameMatcher::learn(double log_value) {
  if (!predicted_for(index_, shift_)) return;
  std::rotate(observations_.begin(), observations_.begin() + 1, observations_.end());
  observations_.back() = {index_, log_value};
  observation_count_ = std::min(observation_count_ + 1, kObservations);
  const bool various =
      std::any_of(observations_.begin(), observations_.end(),
                  [&](const Observation& observation) { return !same(observation.log_value, log_value); });
  if (observation_count_ < kObservations || !various || explains(shift_)) return;
  for (int distance = 1; distance <= kMaxShift; ++distance) {
    for (const int shift : {shift_ - distance, shift_ + distance}) {
      if (std::abs(shift) > kMaxShift || !explains(shift)) continue;
      shift_ = shift;
      ++relocks_;
      return;
    }
  }
}

int FrameMatcher::slot_of(const ExposureClaim& label) const {
  const double value = label.log_value();
  if (const auto& pulse = triggers_.last(); triggered_ && pulse->planned.slot < schedule_.slots())
    if (same(triggered_->log_value(), value)) return pulse->late ? -1 : pulse->planned.slot;
  const int delay = options_.delays ? std::max(options_.delays->exposure, options_.delays->gain) - shift_ : 0;
  if (const SentRequest* sent = written_at(static_cast<std::int64_t>(index_) - delay); sent != nullptr)
    if (sent->slot < schedule_.slots() && same(log_product(schedule_.slot(sent->slot).exposure), value))
      return sent->slot;
  int slot = -1;
  for (int i = 0; i < schedule_.slots(); ++i) {
    if (!same(log_product(schedule_.slot(i).exposure), value)) continue;
    if (slot >= 0) return -1;  // two slots have this exposure
    slot = i;
  }
  return slot;
}

}  // namespace hdrcam
