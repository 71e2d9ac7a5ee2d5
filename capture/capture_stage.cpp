#include "capture/capture_stage.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "capture/control_latency.h"

namespace hdrcam {
namespace {

PixelCodes codes_of(const StreamMode& mode, const CameraCapabilities& offers) {
  PixelCodes codes = codes_of(mode.format);
  if (offers.recorded) codes.linear = offers.recorded->linear;
  return codes;
}

// Of a camera that sets its exposures itself, which it must have; empty for others.
Result<std::vector<Exposure>> cycle_of(const CameraCapabilities& offers) {
  std::vector<Exposure> cycle;
  if (offers.sets_exposure) return cycle;
  for (const ExposureRequest& exposure : offers.cycle)
    cycle.push_back({exposure.exposure, exposure.analogue_gain});
  if (!cycle.empty() && cycle.size() <= ExposureSchedule::kMaxSlots) return cycle;
  return Error{ErrorCode::Unsupported,
               fmt::format("'{}' does not let its exposure be set, and its frames follow no cycle of 1 to {} "
                           "exposures; choose another camera, or read a recording without --pace realtime",
                           offers.id, int{ExposureSchedule::kMaxSlots})};
}

Result<void> check_delays(const ControlDelays& delays) {
  const auto [least, most] = std::minmax(delays.exposure, delays.gain);
  if (least >= 0 && most <= kMaxDelay) return {};
  return Error{ErrorCode::Invalid,
               fmt::format("control delays of {} and {} frames are out of range; give 0 to {}",
                           delays.exposure, delays.gain, kMaxDelay)};
}

}  // namespace

Result<std::unique_ptr<CaptureStage>> CaptureStage::open(Camera& camera, SyncLine* strobe,
                                                         std::span<const Exposure> cycle, Mains mains,
                                                         const CaptureOptions& options) {
  const StreamMode mode = TRY(camera.configure(options.mode, options.buffers));
  const CameraCapabilities& offers = camera.capabilities();
  const std::vector<Exposure> own_cycle = TRY(cycle_of(offers));
  for (const auto& delays : {options.delays, offers.delays})
    if (delays) TRY(check_delays(*delays));
  if (options.trigger != nullptr && !offers.sets_exposure)
    return Error{ErrorCode::Unsupported,
                 fmt::format("'{}' cannot be triggered: its frames come as they were recorded; leave out "
                             "--trigger-line, or choose a camera",
                             offers.id)};
  const auto schedule =
      TRY(offers.sets_exposure ? ExposureSchedule::create(cycle, offers, mode.frame_duration, mains)
                               : ExposureSchedule::observed(own_cycle));
  if (options.trigger != nullptr) TRY(PulseTrain::check(options.trigger->options(), schedule, offers));
  return std::unique_ptr<CaptureStage>(new CaptureStage(camera, strobe, options, mode, schedule, mains));
}

CaptureStage::CaptureStage(Camera& camera, SyncLine* strobe, const CaptureOptions& options,
                           const StreamMode& mode, const ExposureSchedule& schedule, Mains mains)
    : camera_(camera),
      strobe_(strobe),
      options_(options),
      mode_(mode),
      codes_(codes_of(mode, camera.capabilities())),
      schedule_(schedule),
      mains_(mains),
      sensor_(known_sensor(camera.capabilities().model)),
      black_(options.black_level, camera.capabilities(), sensor_, codes_.linear),
      photometer_(black_.first_response()),
      requests_(camera, options.clock),
      trigger_(options.trigger) {
  collect_warnings();
}

FrameMatcherOptions CaptureStage::matching() const {
  const CameraCapabilities& offers = camera_.capabilities();
  FrameMatcherOptions matching;
  matching.frame_duration = mode_.frame_duration;
  matching.strobe = strobe_ == nullptr ? StrobePulse::Absent : options_.strobe;
  matching.strobe_after_timestamp = options_.strobe_after_timestamp;
  matching.timestamp_mark = offers.timestamp_mark;
  if (options_.timestamp_mark && offers.sets_exposure) matching.timestamp_mark = *options_.timestamp_mark;
  if (const TriggerOptions* trigger = trigger_.options(); trigger != nullptr) {
    matching.trigger = trigger->mode;
    matching.frame_duration = trigger->interval;
  }
  if (matching.trigger == TriggerMode::PulseWidth) {
    // the exposure is the pulse's, whatever was requested
  } else if (!offers.sets_exposure) {
    // a recording plays the camera: no request acted on its frames
  } else if (options_.delays) {
    matching.delays = options_.delays;
  } else if (offers.exposure_per_request) {
    matching.delays = ControlDelays{};
  } else if (offers.delays) {
    matching.delays = offers.delays;
  } else if (!offers.reports_exposure && sensor_) {
    matching.delays = sensor_->delays;
  }
  return matching;
}

bool CaptureStage::nobody_states_exposures() const {
  const FrameMatcherOptions how = matching();
  return !how.delays && !camera_.capabilities().reports_exposure && how.trigger != TriggerMode::PulseWidth;
}

int CaptureStage::buffers() const { return camera_.capabilities().buffers.value_or(options_.buffers); }

// Until the first frame of another cycle: the requests before it come first, then its controls take their
// time.
int CaptureStage::latency_frames() const {
  const ControlDelays usual{kUsualDelay, kUsualDelay};
  const ControlDelays delays = matching().delays.value_or(usual);
  return buffers() + std::max(delays.exposure, delays.gain);
}

std::string CaptureStage::exposures_account() const {
  const bool none_known = counters_.emitted > 0 && counters_.unknown == counters_.emitted;
  if (!none_known || !nobody_states_exposures() || !all_same(schedule_.cycle())) return "";
  return fmt::format(
      "the exposure of every frame is unknown: '{}' does not report it, its control delay is unknown, and "
      "pictures do not tell it where all have the same; run 'hdrcam calibrate delay' once, or give a cycle "
      "such as --shutter 1ms,4ms,16ms",
      camera_.capabilities().id);
}

void CaptureStage::collect_warnings() {
  const CameraCapabilities& offers = camera_.capabilities();
  for (int i = 0; i < schedule_.slots(); ++i)
    if (schedule_.slot(i).flickers)
      warnings_.push_back(
          fmt::format("shutter {} is shorter than half a mains period and will flicker under lamps",
                      describe(schedule_.slot(i).exposure.time)));
  if (nobody_states_exposures())
    warnings_.push_back(
        fmt::format("'{}' does not report exposures and its control delay is unknown; {}; run 'hdrcam "
                    "calibrate delay' once",
                    offers.id,
                    all_same(schedule_.cycle()) ? "pictures do not tell it where all have the same"
                                                : "frames are labelled by their pictures alone"));
  if (buffers() < options_.buffers)
    warnings_.push_back(
        fmt::format("'{}' has {} buffers, not the {} of --buffers, and loses frames sooner while the program "
                    "is held up; where its memory is short, a smaller size gives it more",
                    offers.id, buffers(), options_.buffers));
  if (black_.unreported())
    warnings_.push_back(fmt::format(
        "the black level of '{}' is unknown and taken for 0 unless its frames state it; if it is higher, "
        "short exposures show the shadows too bright; give --black-level, in codes of 255",
        offers.id));
}

void CaptureStage::restart_matching() {
  matcher_.emplace(matching(), schedule_);
  proof_.forget();
  proof_.set_cycle(schedule_.cycle());
  if (const auto limits = exposure_limits(); limits && options_.adapt == Adapt::Light)
    adaptation_.emplace(*limits, latency_frames());
  lost_since_emitted_ = 0;
  last_emitted_.reset();
  last_request_ = {};
  drops_.end();
}

Result<void> CaptureStage::start() {
  restart_matching();
  stopped_ = false;
  TRY(camera_.start());
  TRY(requests_.fill(*matcher_, buffers()));
  return trigger_.start(schedule_);
}

Result<void> CaptureStage::stop() {
  stopped_ = true;
  trigger_.stop();
  return camera_.stop();
}

void CaptureStage::settle_trigger() {
  if (trigger_.options() == nullptr) return;
  trigger_.drain(*matcher_);
  (void)drain_strobe();
  trigger_.settle_last();
  counters_.trigger = trigger_.counters();
}

// Takes the edges that wait, but not without end: a line that floats has the next one whenever one is taken.
Result<void> CaptureStage::drain_strobe() {
  if (strobe_ == nullptr || options_.strobe == StrobePulse::Absent) return {};
  for (std::size_t edges = 0; edges < 4 * SyncLine::kMostWaiting; ++edges) {
    const Result<Edge> edge = strobe_->wait_edge(Duration(0));
    if (edge) {
      matcher_->strobe(edge.value());
      trigger_.answer(edge.value());
    } else if (edge.error().code == ErrorCode::Timeout) {
      break;
    } else {
      return edge.error();
    }
  }
  return {};
}

// Ten frames of a slow camera are minutes: who wants the run to end does not wait for them.
Result<CapturedBuffer> CaptureStage::wait_in_parts(const Ends& ends) {
  constexpr Duration kPart = std::chrono::seconds(2);
  for (Duration before{0};;) {
    const Duration part = ends ? std::min(kPart, options_.patience - before) : options_.patience;
    Result<CapturedBuffer> waited = camera_.wait(part);
    if (waited || waited.error().code != ErrorCode::Timeout) return waited;
    if (before + part >= options_.patience) {
      Error silent = waited.error();
      if (before > Duration(0)) silent.message += fmt::format(", nor in the {} before", describe(before));
      return silent;
    }
    if (ends()) return interrupted();
    before += part;
  }
}

// Waits once more where the time ran out and hardly a pulse was driven meanwhile: the sensor had nothing to
// answer.
Result<CapturedBuffer> CaptureStage::wait(const Ends& ends) {
  const std::uint64_t driven = trigger_.driven();
  Result<CapturedBuffer> waited = wait_in_parts(ends);
  if (!waited && waited.error().code == ErrorCode::Timeout && trigger_.held_up(driven, options_.patience))
    waited = wait_in_parts(ends);
  if (!waited) return trigger_.no_answer(waited.error());
  return waited;
}

Error CaptureStage::interrupted() const {
  return {ErrorCode::Interrupted, fmt::format("capture from '{}' was stopped", camera_.capabilities().id)};
}

// A camera that another thread stopped meanwhile refuses requests as one that was never started.
Error CaptureStage::refusal(const Error& of_request) const { return stopped_ ? interrupted() : of_request; }

Result<void> CaptureStage::next(CapturedFrame& frame, const Ends& ends) {
  TRY(std::exchange(last_request_, {}));
  for (;;) {
    bool emitted = false;
    {
      const Result<CapturedBuffer> waited = wait(ends);
      if (!waited) return waited.error();
      const CapturedBuffer& buffer = waited.value();
      requests_.completed();
      trigger_.drain(*matcher_);
      TRY(trigger_.check_driven());
      TRY(drain_strobe());
      emitted = TRY(take(buffer, frame));
    }  // the buffer goes back, so that the next request finds it
    const Result<bool> topped_up = requests_.top_up(*matcher_);
    if (topped_up)
      counters_.requests_late += !topped_up.value();
    else if (emitted)
      last_request_ = refusal(topped_up.error());
    else
      return refusal(topped_up.error());
    if (emitted) return {};
  }
}

void CaptureStage::count(const CapturedBuffer& buffer, const MatchedFrame& matched) {
  counters_.lost_by_camera += static_cast<std::uint64_t>(matched.lost_before);
  counters_.repeated_cookies += matched.cookie_repeated;
  counters_.unreported += !buffer.exposure;
  counters_.strobed += matched.strobed;
  counters_.triggered += matched.pulse.has_value();
  counters_.pulses_forgotten += matched.pulse_forgotten;
  counters_.controls_late += buffer.control_late;
}

Result<bool> CaptureStage::take(const CapturedBuffer& buffer, CapturedFrame& frame) {
  ++counters_.captured;
  const MatchedFrame matched = matcher_->match(buffer);
  count(buffer, matched);
  lost_since_emitted_ += matched.lost_before + matched.left_out_before;
  trigger_.settle(buffer.timestamp);
  counters_.trigger = trigger_.counters();
  if (buffer.damaged) {
    ++counters_.damaged, ++lost_since_emitted_;
    TRY(drops_.damaged(camera_.capabilities().id));
    return false;
  }
  if (const Result<void> unpacked = unpack_pixels(buffer, options_.unpack, frame.raw.codes); !unpacked) {
    ++counters_.undecodable, ++lost_since_emitted_;
    TRY(drops_.not_decoded(camera_.capabilities().id, unpacked.error()));
    return false;
  }
  drops_.end();
  judge(buffer, matched, frame);
  follow_light(frame);
  ++counters_.emitted;
  counters_.count(frame.proof);
  return true;
}

// The number and time of a frame are the driver's while they increase, as every reader of a recording
// demands. Where the counter repeats or restarts, or the time goes back, the frame follows the last one by as
// many frames as the matcher counts.
void CaptureStage::set_number_and_time(const CapturedBuffer& buffer, const MatchedFrame& matched,
                                       Duration exposure, FrameFacts& facts) {
  facts.sequence = buffer.sequence;
  facts.timestamp = buffer.centre.value_or(matched.centre(exposure, buffer.readout));
  if (last_emitted_) {
    const std::uint64_t frames = std::max<std::uint64_t>(1, matched.index - last_emitted_->index);
    if (facts.sequence <= last_emitted_->sequence) facts.sequence = last_emitted_->sequence + frames;
    if (facts.timestamp <= last_emitted_->timestamp)
      facts.timestamp =
          last_emitted_->timestamp + static_cast<Duration::rep>(frames) * matcher_->frame_duration();
  }
  last_emitted_ = {facts.sequence, matched.index, facts.timestamp};
}

// Raw frames of different gains may have different black levels.
void CaptureStage::look_at(const Image<std::uint16_t>& codes, const std::optional<BlackLevel>& black) {
  const auto observe = [&] { photometer_.observe(codes, codes_.layout, codes_.bits, picture_); };
  if (codes_.linear && black != black_.stated()) {
    const PhotometricResponse of_others = photometer_.response();
    photometer_.set_response(PhotometricResponse::before_any_fit(codes_.linear, black));
    observe();
    return photometer_.set_response(of_others);
  }
  observe();
  if (const auto response = black_.narrow(picture_)) {
    photometer_.set_response(*response);
    proof_.forget();
    observe();
  }
}

void CaptureStage::judge(const CapturedBuffer& buffer, const MatchedFrame& matched, CapturedFrame& frame) {
  if (black_.adopt(buffer.black_level)) {
    photometer_.set_response(black_.first_response());
    proof_.forget();
  }
  const std::optional<BlackLevel>& black = black_.stated(buffer.black_level);
  look_at(frame.raw.codes, black);
  frame.proof = proof_.judge(matched.evidence, picture_, photometer_);
  if (frame.proof.unique) matcher_->learn(*frame.proof.unique);
  counters_.strobe_misfits +=
      matched.evidence.strobe_width && (frame.proof.strobe_refuses || !frame.proof.trusted());
  counters_.relocks = static_cast<std::uint64_t>(matcher_->relocks());
  frame.shares = {picture_.clipped_share, picture_.dark_share};
  frame.cookie = buffer.cookie;
  set_facts(buffer, matched, black, frame);
}

// What the judgement says of the frame, whose codes are there. The verdict of exposures that a recording took
// from its pictures is limited only now: its slot is that of the judgement.
void CaptureStage::set_facts(const CapturedBuffer& buffer, const MatchedFrame& matched,
                             const std::optional<BlackLevel>& black, CapturedFrame& frame) {
  const ExposureClaim& label = frame.proof.label;
  FrameFacts& facts = frame.raw.facts;
  facts = {};
  set_number_and_time(buffer, matched, label.exposure.time, facts);
  facts.readout_s = to_seconds(buffer.readout);
  facts.exposure_s = to_seconds(label.exposure.time);
  facts.analogue_gain = label.exposure.gain;
  facts.digital_gain = label.digital_gain;
  facts.exposure_source = label.source;
  facts.slot = frame.proof.trusted() ? slot_of(label) : -1;
  facts.black_level = black;
  frame.proof.limit_to(buffer.exposure_source.value_or(ExposureSource::Unknown));
  if (frame.proof.verdict == Verdict::Estimated) facts.exposure_source = ExposureSource::Estimated;
  facts.verdict = frame.proof.verdict;
  if (std::isfinite(frame.proof.within_ev) && frame.proof.within_ev > 0)
    facts.exposure_within_ev = frame.proof.within_ev;
  if (!frame.proof.trusted()) facts.flags |= kFrameExposureUnproved;
  if (lost_since_emitted_ > 0) facts.flags |= kFrameAfterDrop;
  if (buffer.trigger_late || (matched.pulse && matched.pulse->late)) facts.flags |= kFrameTriggerLate;
  facts.T_world_camera = buffer.T_world_camera;
  frame.lost_before = lost_since_emitted_;
  lost_since_emitted_ = 0;
}

void CaptureStage::follow_light(const CapturedFrame& frame) {
  if (!adaptation_) return;
  const auto cycle = adaptation_->observe(slot_for_light(frame), frame.shares);
  if (!cycle) return;
  if (change_cycle(*cycle)) adaptation_->runs(*cycle);  // else the cycle before goes on
}

// Where a cycle repeats an exposure and nothing is known of the control delays, a frame's own slot is not
// known; that its exposure is the shortest or the longest is.
int CaptureStage::slot_for_light(const CapturedFrame& frame) const {
  if (!frame.proof.trusted()) return -1;
  const double log_exposure = frame.proof.label.log_value();
  const auto [shortest, longest] = adaptation_->ends();
  for (const std::size_t end : {shortest, longest}) {
    const int slot = static_cast<int>(end);
    if (same_exposure(log_product(schedule_.slot(slot).exposure), log_exposure)) return slot;
  }
  return frame.raw.facts.slot;
}

// The requests of a camera that sets its exposures itself have no slots.
int CaptureStage::slot_of(const ExposureClaim& label) const {
  if (camera_.capabilities().sets_exposure) return matcher_->slot_of(label);
  return schedule_.nearest_slot({label.exposure.time, label.exposure.gain * label.digital_gain});
}

CameraFacts CaptureStage::facts() const {
  CameraFacts facts = camera_.capabilities().recorded.value_or(CameraFacts());
  facts.name = camera_.capabilities().id;
  facts.width = mode_.width;
  facts.height = mode_.height;
  facts.framerate_hz = 1 / to_seconds(mode_.frame_duration);
  facts.bits = codes_.bits;
  facts.layout = codes_.layout;
  facts.linear = codes_.linear;
  return facts;
}

Result<ExposureSchedule> CaptureStage::schedule_of(std::span<const Exposure> cycle) const {
  const auto schedule =
      TRY(ExposureSchedule::create(cycle, camera_.capabilities(), mode_.frame_duration, mains_));
  if (const TriggerOptions* trigger = trigger_.options(); trigger != nullptr)
    TRY(PulseTrain::check(*trigger, schedule, camera_.capabilities()));
  return schedule;
}

Result<void> CaptureStage::change_cycle(std::span<const Exposure> cycle) {
  const ExposureSchedule schedule = TRY(schedule_of(cycle));
  TRY(trigger_.follow(schedule));
  schedule_ = schedule;
  proof_.set_cycle(schedule_.cycle());
  if (matcher_) matcher_->change_schedule(schedule_);
  ++counters_.cycle_changes;
  return {};
}

Duration CaptureStage::longest_exposure() const {
  const CameraCapabilities& offers = camera_.capabilities();
  const Duration longest =
      std::min(offers.exposure_max, mode_.frame_duration - ExposureSchedule::frame_margin(offers));
  if (!trigger_.exposes()) return longest;
  return std::min(longest, longest_within(PulseTrain::longest_width(*trigger_.options()), offers));
}

std::optional<ExposureLimits> CaptureStage::exposure_limits() const {
  const CameraCapabilities& offers = camera_.capabilities();
  if (!offers.sets_exposure) return std::nullopt;
  const ExposureSchedule::Cycle cycle = schedule_.cycle();
  const bool one_gain = trigger_.exposes();  // nothing ties a gain to a pulse
  const double gain = cycle.front().gain;
  return ExposureLimits{.cycle = {cycle.begin(), cycle.end()},
                        .shortest = offers.exposure_min,
                        .longest = longest_exposure(),
                        .least_gain = one_gain ? gain : offers.gain_min,
                        .greatest_gain = one_gain ? gain : offers.gain_max,
                        .mains = mains_};
}

void CaptureStage::learn_response(const PhotometricResponse::Curve& inverse, const BlackLevel& black_level) {
  photometer_.set_response(PhotometricResponse::known(inverse, black_level));
  black_.settle();
  proof_.forget();
}

}  // namespace hdrcam
