#include "capture/recorded_labels.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "capture/exposure_schedule.h"
#include "capture/white_level.h"

namespace hdrcam {
namespace {

constexpr int kLeastOutOfOrder = 4;  // of one step of the cycle

bool judgeable(const FrameFacts& facts) {
  const bool unlabelled = facts.exposure_source == ExposureSource::Unknown;
  return (facts.flags & kFrameDamaged) == 0 && (facts.has_exposure() || unlabelled);
}

// Merges the judgements of a frame by the frames before it and by the frames after it.
Judgement joined(const Judgement& by_earlier, const Judgement& by_later) {
  if (by_earlier.unique && by_later.unique && !same_exposure(*by_earlier.unique, *by_later.unique)) {
    Judgement divided = by_earlier;
    divided.verdict = Verdict::Contradicted;
    divided.relabelled = false;
    divided.unique.reset();
    return divided;
  }
  if (by_earlier.verdict == Verdict::Proved) return by_earlier;
  if (by_later.unique) return by_later;
  if (by_earlier.unique) return by_earlier;
  return by_earlier.trusted() ? by_later : by_earlier;
}

}  // namespace

RecordedLabels::Label RecordedLabels::label_of(const FrameFacts& facts) {
  return {facts.exposure_s, facts.analogue_gain, facts.digital_gain, facts.slot,
          facts.exposure_source == ExposureSource::Estimated};
}

double RecordedLabels::Label::log_value() const {
  return std::log(exposure_s * analogue_gain * digital_gain);
}

RecordedLabels::RecordedLabels(const CameraFacts& camera, FrameName name_of)
    : camera_(camera),
      name_of_(std::move(name_of)),
      photometer_(PhotometricResponse::before_any_fit(camera.linear, std::nullopt)),
      order_(kLeastOutOfOrder) {}

// An estimated exposure has no time: stops from the middle of the cycle, as `info` shows it.
std::string RecordedLabels::described(const Label& label) const {
  if (!label.estimated)
    return describe(Exposure{from_seconds(label.exposure_s), label.analogue_gain * label.digital_gain});
  double middle = 0;
  for (const Label& of_cycle : cycle_) middle += of_cycle.log_value() / static_cast<double>(cycle_.size());
  const double stops = cycle_.empty() ? 0 : (label.log_value() - middle) / std::numbers::ln2;
  return fmt::format("{:+.2f} EV", std::round(100 * stops) / 100 + 0.0);  // no -0.00
}

// The recording's claim about a frame; empty where the exposure is unknown. nullopt for a frame that cannot
// be judged.
std::optional<FrameEvidence> RecordedLabels::evidence_of(const FrameFacts& facts) const {
  if (!judgeable(facts)) return std::nullopt;
  FrameEvidence evidence;
  if (facts.has_exposure())
    evidence.claims.push_back(
        {{from_seconds(facts.exposure_s), facts.analogue_gain}, facts.digital_gain, facts.exposure_source});
  return evidence;
}

// The candidates are the distinct exposures of the last labels.
void RecordedLabels::learn_cycle(const FrameFacts& facts) {
  constexpr std::size_t kRemembered = 16;  // labels: four rounds of the longest cycle
  if (!facts.has_exposure()) return;
  const Label label = label_of(facts);
  const auto same = [](const Label& a) {
    return [value = a.log_value()](const Label& b) { return same_exposure(value, b.log_value()); };
  };
  if (recent_.size() == kRemembered) recent_.erase(recent_.begin());
  recent_.push_back(label);
  if (std::any_of(cycle_.begin(), cycle_.end(), same(label))) return;

  std::vector<Label> distinct;
  for (const Label& seen : recent_)
    if (std::none_of(distinct.begin(), distinct.end(), same(seen))) distinct.push_back(seen);
  if (distinct.size() > ExposureSchedule::kMaxSlots) distinct.clear();
  cycle_ = std::move(distinct);
  ExposureSchedule::Cycle exposures;
  for (const Label& seen : cycle_)
    exposures.push_back({from_seconds(seen.exposure_s), seen.analogue_gain * seen.digital_gain});
  proof_.set_cycle(exposures);
  proof_.widen_undecided();
}

void RecordedLabels::judge_beginning(std::span<CapturedFrame> frames) {
  if (frames.empty()) return;
  WhiteSearch white(camera_);
  for (const CapturedFrame& frame : frames) {
    if (!black_level_) black_level_ = frame.raw.facts.black_level;
    white.observe(frame.raw);
  }
  white_level_ = white.found();
  for (const CapturedFrame& frame : frames)
    if (judgeable(frame.raw.facts)) learn_cycle(frame.raw.facts);
  std::vector<Judgement> by_later(frames.size());
  ExposureProof backwards = proof_;
  for (std::size_t i = frames.size(); i-- > 0;) {
    const auto evidence = evidence_of(frames[i].raw.facts);
    if (!evidence) continue;
    look_at(frames[i].raw);
    by_later[i] = backwards.judge(*evidence, picture_, photometer_);
  }
  for (std::size_t i = 0; i < frames.size(); ++i) {
    std::optional<Duration> interval;
    if (i > 0)
      interval = frames[i].raw.facts.timestamp - *last_time_;
    else if (frames.size() > 1)  // no frame precedes the first one
      interval = between_begins(frames[0].raw.facts, frames[1].raw.facts);
    finish(frames[i], joined(judge_forward(frames[i]), by_later[i]), interval);
  }
}

void RecordedLabels::judge(CapturedFrame& frame) {
  learn_cycle(frame.raw.facts);
  std::optional<Duration> interval;
  if (last_time_) interval = frame.raw.facts.timestamp - *last_time_;
  const Judgement judgement = judge_forward(frame);
  finish(frame, judgement, interval);
}

// Raw stills of different gains may have different black levels.
void RecordedLabels::look_at(const RawFrame& raw) {
  const auto& own = raw.facts.black_level;
  photometer_.set_response(
      PhotometricResponse::before_any_fit(camera_.linear, own ? own : black_level_, white_level_));
  photometer_.observe(raw.codes, camera_.layout, camera_.bits, picture_);
}

// Returns an empty judgement for a frame that cannot be judged.
Judgement RecordedLabels::judge_forward(const CapturedFrame& frame) {
  const auto evidence = evidence_of(frame.raw.facts);
  if (!evidence) return last_exposure_.reset(), Judgement{};
  look_at(frame.raw);
  const Judgement judgement = proof_.judge(*evidence, picture_, photometer_);
  check_order(frame.raw.facts);
  return judgement;
}

void RecordedLabels::finish(CapturedFrame& frame, const Judgement& judgement,
                            std::optional<Duration> interval) {
  FrameFacts& facts = frame.raw.facts;
  ++frames_;
  last_time_ = facts.timestamp;
  frame.proof = judgement;
  if (judgeable(facts)) settle(frame, judgement);
  check_duration(frame, interval);
}

// Compares the newest picture with the one before it, after the proof. Where a ratio can be taken of the two
// the proof knows more, and the step counts as one without a contradiction.
void RecordedLabels::check_order(const FrameFacts& facts) {
  if (!facts.has_exposure()) return last_exposure_.reset();
  const Exposure exposure{from_seconds(facts.exposure_s), facts.gain()};
  const auto before = std::exchange(last_exposure_, exposure);
  if (!before) return;
  CycleStep step;
  if (const PhotometricSignature* earlier = proof_.incomparable_previous(); earlier != nullptr)
    step = rough_step(*earlier, picture_);
  if (order_.add(log_product(*before), log_product(exposure), step))
    out_of_order_.object(name_of_, facts.sequence,
                         "it is {} than the one before, with an exposure of {} after {}",
                         step.log_ratio > 0 ? "brighter" : "darker", describe(exposure), describe(*before));
}

// Combines the verdict in the recording with the verdict of the pictures.
void RecordedLabels::settle(CapturedFrame& frame, const Judgement& judgement) {
  FrameFacts& facts = frame.raw.facts;
  const bool flagged = (facts.flags & kFrameExposureUnproved) != 0;
  if (judgement.unique && (judgement.relabelled || !facts.has_exposure())) {
    relabel(facts, judgement);
  } else if (flagged && judgement.trusted() && !judgement.unique) {
    const bool contradicted = facts.verdict == Verdict::Contradicted;
    frame.proof.verdict = contradicted ? Verdict::Contradicted : Verdict::Unknown;
  } else if (facts.verdict == Verdict::Proved && judgement.trusted()) {
    frame.proof.verdict = Verdict::Proved;
  }
  frame.proof.limit_to(facts.exposure_source);
  if (frame.proof.verdict == Verdict::Contradicted && facts.has_exposure()) {
    contradicted_.object(name_of_, facts.sequence, "its pictures contradict its exposure of {}",
                         described(label_of(facts)));
  }
  facts.verdict = frame.proof.verdict;
  if (judgement.within_ev > 0 && std::isfinite(judgement.within_ev) && !facts.exposure_within_ev)
    facts.exposure_within_ev = judgement.within_ev;
  facts.flags &= ~kFrameExposureUnproved;
  if (!frame.proof.trusted()) facts.flags |= kFrameExposureUnproved;
}

// Takes time and gains from the frames that have the exposure which the pictures found.
void RecordedLabels::relabel(FrameFacts& facts, const Judgement& judgement) {
  const double value = judgement.label.log_value();
  const auto found = std::min_element(cycle_.begin(), cycle_.end(), [&](const Label& a, const Label& b) {
    return std::abs(a.log_value() - value) < std::abs(b.log_value() - value);
  });
  if (found == cycle_.end()) return;
  if (facts.has_exposure())
    relabelled_.object(name_of_, facts.sequence, "the pictures show an exposure of {}, not the stated {}",
                       described(*found), described(label_of(facts)));
  facts.exposure_s = found->exposure_s;
  facts.analogue_gain = found->analogue_gain;
  facts.digital_gain = found->digital_gain;
  facts.slot = found->slot;
  facts.exposure_source = found->estimated ? ExposureSource::Estimated : ExposureSource::Photometric;
  facts.exposure_within_ev.reset();
}

// An exposure cannot outlast its frame: its duration is wrong, though its ratio to the others may be right.
// An estimated one has no duration. Where exposures end on the camera's grid, the centre of a long one is
// nearer than a frame to that of a short one before it.
void RecordedLabels::check_duration(CapturedFrame& frame, std::optional<Duration> interval) {
  FrameFacts& facts = frame.raw.facts;
  if (!interval || !facts.has_exposure_time()) return;
  const double frame_s = std::max(to_seconds(*interval), 1 / camera_.framerate_hz);
  if (!outlasts_frame(facts.exposure_s, frame_s)) return;
  if (frame.proof.verdict == Verdict::Proved) facts.verdict = frame.proof.verdict = Verdict::Plausible;
  overlong_.object(name_of_, facts.sequence,
                   "an exposure of {:.6g} s does not fit the frame interval of {:.6g} s", facts.exposure_s,
                   frame_s);
}

std::optional<std::string> RecordedLabels::objection() const {
  for (const Objections* objections : {&relabelled_, &contradicted_})
    if (objections->count > 0) return objections->first;
  if (order_.objects()) return out_of_order_.first;
  if (overlong_.count > 0) return overlong_.first;
  return std::nullopt;
}

std::vector<std::string> RecordedLabels::warnings() const {
  std::vector<std::string> warnings;
  const auto warn = [&](const Objections& objections, const char* what_one, const char* what_more) {
    if (objections.count > 0)
      warnings.push_back(fmt::format("{} of {} frames {}; {}", objections.count, frames_,
                                     objections.count == 1 ? what_one : what_more, objections.first));
  };
  warn(relabelled_, "had a wrong exposure and was relabelled from the pictures",
       "had a wrong exposure and were relabelled from the pictures");
  warn(contradicted_, "is kept out of the fit: its pictures contradict its exposure, which should be checked",
       "are kept out of the fit: their pictures contradict their exposures, which should be checked");
  constexpr const char* kDarker =  // of several, or the order has no objection
      "are darker than their neighbours where their exposures should make them brighter, or the reverse: "
      "the exposures should be checked";
  if (order_.objects()) warn(out_of_order_, kDarker, kDarker);
  warn(overlong_,
       "states an exposure longer than the frame interval, so motion blur is modelled only where frames show "
       "it",
       "state an exposure longer than the frame interval, so motion blur is modelled only where frames show "
       "it");
  return warnings;
}

}  // namespace hdrcam
