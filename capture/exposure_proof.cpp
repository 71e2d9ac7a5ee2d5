#include "capture/exposure_proof.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "capture/control_latency.h"

namespace hdrcam {
namespace {

// The assignment of a frame that is left out.
constexpr double kOutlier = std::numeric_limits<double>::quiet_NaN();

// A strobe pulse lasts as long as the exposure, except for the interrupt latency at its two edges.
Duration strobe_slack(Duration exposure) {
  constexpr Duration kLatency = std::chrono::microseconds(60);
  constexpr int kShare = 16;  // of the exposure
  return kLatency + exposure / kShare;
}

bool strobe_allows(Duration width, Duration exposure) {
  return std::chrono::abs(width - exposure) <= strobe_slack(exposure);
}

// By how many stops an exposure that was measured to within so much may be longer.
double stops_within(Duration within, Duration exposure) {
  return std::log2(1 + to_seconds(within) / to_seconds(exposure));
}

// By how many stops the gains of a cycle differ.
double gain_stops(std::span<const Exposure> cycle) {
  if (cycle.empty()) return 0;
  const auto [least, most] = std::ranges::minmax(cycle, {}, &Exposure::gain);
  return std::log2(most.gain / least.gain);
}

// The first claim that states `value`; null for none.
const ExposureClaim* claim_saying(const FrameEvidence& evidence, double value) {
  const auto found = std::ranges::find_if(
      evidence.claims, [&](const ExposureClaim& claim) { return same_exposure(claim.log_value(), value); });
  return found == evidence.claims.end() ? nullptr : found;
}

// The first of these exposures that is `value`; null for none.
const Exposure* exposure_of(std::span<const Exposure> exposures, double value) {
  const auto found = std::ranges::find_if(
      exposures, [&](const Exposure& exposure) { return same_exposure(log_product(exposure), value); });
  return found == exposures.end() ? nullptr : &*found;
}

}  // namespace

double ExposureClaim::log_value() const { return log_product(exposure) + std::log(digital_gain); }

void ExposureProof::set_cycle(std::span<const Exposure> cycle) {
  HDRCAM_CHECK_LE(cycle.size(), kCandidates / 3);
  const Candidates earlier = candidates_;
  const std::size_t kept = std::min(earlier.size(), kCandidates - cycle.size());
  candidates_ = Candidates(cycle);
  for (std::size_t i = 0; i < kept; ++i) candidates_.push_back(earlier[i]);
  current_count_ = cycle.size();
  proved_in_current_ = undecided_ = 0;
  change_denied_ = false;
  exposures_differ_ = !all_same(cycle);
}

void ExposureProof::widen_undecided() {
  for (std::size_t age = 0; age < count_; ++age) {
    Frame& frame = back(age);
    if (frame.judgement.trusted()) continue;
    for (const Exposure& exposure : current_cycle()) {
      const double value = log_product(exposure);
      const auto same = [&](double other) { return same_exposure(other, value); };
      if (frame.values.size() < kValues && std::ranges::none_of(frame.values, same))
        frame.values.push_back(value);
    }
  }
}

// The distinct exposures of the cycle that the strobe allows. Where the best claim is an exposure outside the
// cycle, it is a candidate too, in place of a neighbour that no picture could distinguish from it.
void ExposureProof::gather_values(const FrameEvidence& evidence, Frame& frame) const {
  frame.values.clear();
  const auto add = [&](const Exposure& exposure, double value, double distance) {
    if (evidence.strobe_width && !strobe_allows(*evidence.strobe_width, exposure.time)) return;
    const auto near = [&](double other) { return std::abs(other - value) <= distance; };
    if (std::ranges::none_of(frame.values, near)) frame.values.push_back(value);
  };
  const auto is_best_claim = [&](const Exposure& exposure) {
    return claim_saying(evidence, log_product(exposure)) == evidence.claims.begin();
  };
  const bool beyond = !evidence.claims.empty() && std::ranges::none_of(all_candidates(), is_best_claim);
  if (beyond) add(evidence.claims[0].exposure, evidence.claims[0].log_value(), 0);
  for (const Exposure& exposure : all_candidates()) {
    const double value = log_product(exposure);
    if (beyond && std::abs(value - evidence.claims[0].log_value()) <= kSameToPictures) continue;
    add(exposure, value, kSameExposure);
  }
}

// What an exposure of the cycle is if each time goes with the gain `shift` slots after its own, as where a
// control delay is wrong for one of the two. Several where slots are alike; itself where it is of no slot.
InlineList<double, ExposureProof::kCandidates> ExposureProof::with_gain_of(std::size_t shift,
                                                                           double value) const {
  InlineList<double, kCandidates> values;
  const auto cycle = current_cycle();
  for (std::size_t i = 0; shift > 0 && i < cycle.size(); ++i)
    if (std::abs(log_product(cycle[i]) - value) <= kSameToPictures)
      values.push_back(value + std::log(cycle[(i + shift) % cycle.size()].gain / cycle[i].gain));
  if (values.empty()) values.push_back(value);
  return values;
}

// Whether frame `age` may have this exposure, given those of the newer frames.
bool ExposureProof::fits(std::size_t age, double value, const std::array<double, kWindow>& assigned) const {
  for (std::size_t newer = 0; newer < age; ++newer) {
    const double other = assigned[newer];
    if (std::isnan(other)) continue;
    const auto& ratio = back(newer).ratio_from[age - newer - 1];
    if (ratio && !ratio->allows(other - value)) return false;
  }
  return true;
}

// The least number of outliers among all explanations with gains so shifted, given the assignment of the
// newer frames; kNever if it is not below bound.
int ExposureProof::fewest_outliers(std::size_t age, int outliers, int bound, std::size_t shift,
                                   std::array<double, kWindow>& assigned) const {
  if (outliers >= bound) return kNever;
  if (age == count_) return outliers;
  int fewest = kNever;
  const Frame& frame = back(age);
  const bool proved = frame.judgement.verdict == Verdict::Proved;
  for (const double value : frame.values) {
    if (proved && !same_exposure(value, frame.judgement.label.log_value())) continue;
    for (const double shown : with_gain_of(proved ? 0 : shift, value)) {
      if (!fits(age, shown, assigned)) continue;
      assigned[age] = shown;
      fewest = std::min(fewest, fewest_outliers(age + 1, outliers, std::min(bound, fewest), shift, assigned));
      if (fewest == outliers) return fewest;
    }
  }
  assigned[age] = kOutlier;
  return std::min(fewest, fewest_outliers(age + 1, outliers + 1, std::min(bound, fewest), shift, assigned));
}

// The same, if the newest frame has the time of `value` and another slot's gain that pictures can tell from
// its own.
int ExposureProof::fewest_with_other_gains(double value) const {
  std::array<double, kWindow> assigned{};
  int fewest = kNever;
  for (std::size_t shift = 1; shift < current_count_; ++shift)
    for (const double shown : with_gain_of(shift, value)) {
      if (std::abs(shown - value) <= kSameToPictures) continue;
      assigned[0] = shown;
      fewest = std::min(fewest, fewest_outliers(1, 0, kBound, shift, assigned));
    }
  return fewest;
}

ExposureProof::Explanations ExposureProof::explain(bool time_alone) const {
  Explanations result;
  const Frame& newest = back(0);
  std::array<double, kWindow> assigned{};
  std::size_t best = 0;
  int fewest = kNever, second = kNever;
  for (std::size_t i = 0; i < newest.values.size(); ++i) {
    assigned[0] = newest.values[i];
    const int outliers = fewest_outliers(1, 0, kBound, 0, assigned);
    result.outliers_if[i] = outliers;
    if (outliers < fewest) {
      second = fewest;
      fewest = outliers;
      best = i;
    } else {
      second = std::min(second, outliers);
    }
  }
  assigned[0] = kOutlier;
  result.outliers_if_newest_is_one = fewest_outliers(1, 1, kBound, 0, assigned);
  result.fewest_outliers = fewest;
  result.fits_nothing = result.outliers_if_newest_is_one < fewest;
  if (fewest <= kMostOutliers && fewest + kMargin <= second && fewest < result.outliers_if_newest_is_one)
    result.unique = best;
  if (time_alone && fewest < kNever) {
    const int otherwise = fewest_with_other_gains(newest.values[best]);
    if (otherwise < fewest + kMargin) result.unique.reset();
    result.other_gains_fit_better = otherwise < fewest;
  }
  return result;
}

// How often the ratios to trusted neighbours contradict a claim, and how often they support it.
ExposureProof::Votes ExposureProof::neighbours_on(double claimed) const {
  Votes votes;
  for (std::size_t age = 1; age < count_; ++age) {
    const Frame& other = back(age);
    const auto& ratio = back(0).ratio_from[age - 1];
    if (!ratio || !other.judgement.trusted()) continue;
    ++(ratio->allows(claimed - other.judgement.label.log_value()) ? votes.in_favour : votes.against);
  }
  return votes;
}

// Whether the claim needs more outliers than the best explanation does. A claim outside all counted
// candidates makes every frame an outlier.
bool ExposureProof::another_explains_better(double claimed, const Explanations& explanations) const {
  const auto& values = back(0).values;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (same_exposure(values[i], claimed)) return explanations.outliers_if[i] > explanations.fewest_outliers;
  return explanations.fewest_outliers < kNever;
}

// Whether the picture differs from those of the claimed exposure as by the light of lamps on the mains, of
// which a short exposure sees one moment: by less than 1.3 stops, by less than half of what it differs from
// those of any other exposure, and from these as the claim says, but for a part of that light. Of a cycle of
// one exposure nothing else can differ.
bool ExposureProof::differs_as_by_light(double claimed) const {
  constexpr double kMost = 0.9, kShare = 0.45;  // ln; of the difference
  const auto each = [&](const auto& visit) {
    for (std::size_t age = 1; age < count_; ++age)
      if (const auto& ratio = back(0).ratio_from[age - 1]; ratio && back(age).judgement.trusted())
        visit(*ratio, claimed - back(age).judgement.label.log_value());
  };
  double light = 0;
  bool compared = false;
  each([&](const PhotometricRatio& ratio, double difference) {
    if (std::abs(difference) > kSameExposure) return;
    compared = true;
    if (std::abs(ratio.log_ratio) > std::abs(light)) light = ratio.log_ratio;
  });
  bool fits = compared && std::abs(light) <= kMost, others = false;
  each([&](const PhotometricRatio& ratio, double difference) {
    if (std::abs(difference) <= kSameExposure) return;
    others = true;
    const double bright = difference + std::max(light, 0.0), dark = difference + std::min(light, 0.0);
    fits = fits && std::abs(light) <= kShare * std::abs(ratio.log_ratio) && ratio.low <= bright &&
           dark <= ratio.high;
  });
  return fits && (others || !exposures_differ_);
}

// Whether a claim of this source stands though the light of lamps contradicts it: one that states the frame
// by itself or by its place in a cycle at once; what a camera reports, which may have exposed otherwise than
// it says, only where the light of another frame of late changed, too.
bool ExposureProof::outweighs_light(ExposureSource source) const {
  switch (source) {
    case ExposureSource::Embedded:
    case ExposureSource::Declared:
    case ExposureSource::Estimated:
      return true;
    case ExposureSource::Reported:
      for (std::size_t age = 1; age < count_; ++age)
        if (back(age).judgement.as_by_light) return true;
      return false;
    default:
      return false;
  }
}

// How far the truth may be from a label that the neighbours confirm: the width of the best ratio; through a
// neighbour of the same exposure, at least that neighbour's own uncertainty.
double ExposureProof::open_interval_ev(double label) const {
  double open = std::numeric_limits<double>::infinity();
  for (std::size_t age = 1; age < count_; ++age) {
    const Judgement& other = back(age).judgement;
    const auto& ratio = back(0).ratio_from[age - 1];
    if (!ratio || !other.trusted()) continue;
    const double difference = label - other.label.log_value();
    if (!ratio->allows(difference)) continue;
    double width = std::max(ratio->high - difference, difference - ratio->low);
    if (std::abs(difference) <= kSameExposure) {
      if (other.verdict != Verdict::Proved) continue;
      width = std::max(width, other.within_ev * std::numbers::ln2);
    }
    open = std::min(open, width);
  }
  return open / std::numbers::ln2;
}

// The pictures are unanimous: does a claim agree?
Judgement ExposureProof::unique_judgement(const FrameEvidence& evidence, double value) const {
  Judgement judgement;
  judgement.unique = value;
  const ExposureClaim* claim = claim_saying(evidence, value);
  const bool is_best = claim == evidence.claims.begin();
  judgement.verdict = is_best ? Verdict::Proved : Verdict::Plausible;
  if (claim != nullptr) {
    judgement.label = *claim;
  } else {
    const Exposure* slot = exposure_of(all_candidates(), value);
    HDRCAM_CHECK(slot != nullptr);
    judgement.label = {*slot, 1, ExposureSource::Photometric};
    judgement.relabelled = !evidence.claims.empty();
  }
  judgement.within_ev = open_interval_ev(judgement.label.log_value());
  const Duration time = judgement.label.exposure.time;
  if (evidence.strobe_width)
    judgement.within_ev = std::min(
        judgement.within_ev, stops_within(strobe_slack(time), time) +
                                 std::min(gain_stops(current_cycle()), kSameToPictures / std::numbers::ln2));
  if (evidence.pulse_within && is_best)
    judgement.within_ev = std::min(judgement.within_ev, stops_within(*evidence.pulse_within, time));
  // Unanimous, but the neighbours are not trusted themselves.
  if (std::isinf(judgement.within_ev)) judgement.verdict = Verdict::Plausible;
  return judgement;
}

Judgement ExposureProof::weigh(const FrameEvidence& evidence, const Explanations& explanations) const {
  if (explanations.unique && (exposures_differ_ || evidence.strobe_width))
    return unique_judgement(evidence, back(0).values[*explanations.unique]);
  Judgement judgement;
  if (evidence.claims.empty()) return judgement;
  judgement.label = evidence.claims.front();
  const double claimed = judgement.label.log_value();
  const Votes votes = neighbours_on(claimed);
  const bool claims_agree =
      std::all_of(evidence.claims.begin() + 1, evidence.claims.end(),
                  [&](const ExposureClaim& other) { return same_exposure(other.log_value(), claimed); });

  if (explanations.fits_nothing || (votes.against > 0 && votes.against >= votes.in_favour) ||
      another_explains_better(claimed, explanations) || explanations.other_gains_fit_better) {
    judgement.as_by_light = differs_as_by_light(claimed);
    judgement.verdict = judgement.as_by_light && outweighs_light(judgement.label.source)
                            ? Verdict::Plausible
                            : Verdict::Contradicted;
  } else if (!claims_agree ||
             (judgement.label.source == ExposureSource::Predicted && evidence.prediction_doubtful)) {
    judgement.verdict = Verdict::Unknown;
  } else if (!exposures_differ_ && judgement.label.source == ExposureSource::Embedded &&
             votes.in_favour >= 2 && current_count_ > 0) {
    judgement.verdict = Verdict::Proved;  // the sensor's embedded data says so, and the light did not change
    judgement.within_ev = open_interval_ev(claimed);
  } else {
    judgement.verdict = Verdict::Plausible;
  }
  return judgement;
}

// Once enough frames of the new cycle have been proved, the earlier ones are dropped. Pictures do not tell
// two cycles apart where all exposures changed by one factor, and that is too small for them, or no claim is
// right, or the frames before the change are forgotten: the earlier cycles are dropped when more frames
// without a decision follow each other than requests can be left from before.
void ExposureProof::retire_earlier_cycles(const FrameEvidence& evidence, const Judgement& judgement) {
  // Queued requests, and frames until their controls act.
  constexpr int kMostUndecided = kMostBuffers + kMaxDelay;
  if (candidates_.size() == current_count_) return;
  const auto is_current = [&](double value) { return exposure_of(current_cycle(), value) != nullptr; };
  if (judgement.unique && !is_current(*judgement.unique) && !evidence.claims.empty() &&
      is_current(evidence.claims.front().log_value()))
    change_denied_ = true;
  const bool decided = judgement.unique || (judgement.trusted() && change_denied_);
  undecided_ = decided ? 0 : undecided_ + 1;
  if (judgement.verdict == Verdict::Proved) {
    const bool current = is_current(judgement.label.log_value());
    proved_in_current_ = current ? proved_in_current_ + 1 : 0;
    if (current) change_denied_ = false;
  }
  if (proved_in_current_ >= 2 * kWindow || undecided_ > kMostUndecided)
    candidates_ = Candidates(current_cycle());
}

Judgement ExposureProof::judge(const FrameEvidence& evidence, const PhotometricSignature& picture,
                               Photometer& photometer) {
  newest_ = (newest_ + 1) % kWindow;
  count_ = std::min<std::size_t>(count_ + 1, kWindow);
  Frame& frame = back(0);
  frame.picture = picture;
  frame.judgement = {};
  for (std::size_t age = 1; age < count_; ++age)
    frame.ratio_from[age - 1] = photometer.ratio(back(age).picture, picture);
  const bool strobe_refuses = evidence.strobe_width && !evidence.claims.empty() &&
                              !strobe_allows(*evidence.strobe_width, evidence.claims[0].exposure.time);
  FrameEvidence counted = evidence;
  if (strobe_refuses && evidence.claims[0].source == ExposureSource::Embedded) counted.strobe_width.reset();
  gather_values(counted, frame);
  frame.judgement = weigh(counted, explain(counted.strobe_width.has_value()));
  // without the pictures' word the sensor's stands against the pulse's
  if (strobe_refuses && !frame.judgement.unique && frame.judgement.verdict == Verdict::Proved)
    frame.judgement.verdict = Verdict::Plausible;
  frame.judgement.strobe_refuses = strobe_refuses;
  retire_earlier_cycles(counted, frame.judgement);
  return frame.judgement;
}

}  // namespace hdrcam
