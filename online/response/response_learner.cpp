#include "online/response/response_learner.h"

#include <algorithm>
#include <cmath>
#include <system_error>
#include <utility>

#include "online/response/first_light.h"

namespace hdrcam {
namespace {

// Between looks, in frames: as long as half of the stream was so far, so that they cost nothing in the mean.
long pause_after(long frames, long least) {
  constexpr long kMost = 300;
  return std::clamp(frames / 2, least, kMost);
}

// What the frame states, in its codes, whose white is 255 whatever the camera's is.
std::optional<BlackLevel> stated_black(const ExposedFrame& frame) {
  std::optional<BlackLevel> black = frame.facts.black_level;
  if (black && !frame.white.is_largest_code())
    for (std::size_t c = 0; c < 3; ++c) black->set(c, (*black)[c] * (kMaxCode / frame.white[c]));
  return black;
}

ResponseEstimator begun_with(const ExposedFrame& first, const ResponseLearner::Options& options) {
  return ResponseEstimator(stated_black(first), options.code_step, options.bits);
}

// On a thread of its own; where the system has none to give, by whoever asks for the result.
template <class Fit>
std::future<ResponseEstimate> started(const Fit& fit) {
  try {
    return std::async(std::launch::async, fit);
  } catch (const std::system_error&) {
    return std::async(std::launch::deferred, fit);
  }
}

}  // namespace

void ResponseLearner::see_first(const ExposedFrame& frame, const CompactFrame* before) {
  if (before == nullptr) estimator_ = begun_with(frame, options_);
  estimator_.add_noise(frame);
  if (before == nullptr) return;
  ExposedFrame restored;
  before->restore(restored);
  estimator_.add_pair(restored, frame);
}

ResponseEstimate ResponseLearner::first(std::span<const CompactFrame> frames, const NoiseModel& noise,
                                        WorkerPool& pool) {
  const std::vector<float> light = light_of(frames);
  if (!light.empty()) {
    ExposedFrame first;
    frames[0].restore(first);
    estimator_ = begun_with(first, options_);
    look(frames, light, SceneCuts::Possible);
  }
  // not every pair of frames spans a cut; but where only exposures are learned, the stated ones are better
  if (estimator_.pairs() == 0 && !options_.known) look(frames, light, SceneCuts::None);
  frames_ = look_at_ = static_cast<long>(frames.size());
  if (options_.known) {
    measured_ = true;
    return of_stated(estimator_.estimate_under(*options_.known, noise, &pool), frames, light);
  }
  ResponseEstimate estimate = estimator_.estimate(noise, options_.model, &pool);
  measured_ = is_measured(estimate);
  uncertainty_ = uncertainty_of(estimate.response);
  return of_stated(std::move(estimate), frames, light);
}

std::vector<float> ResponseLearner::light_of(std::span<const CompactFrame> frames) const {
  if (!options_.light_may_change) return {};
  return unsteady_light(frames, options_.known ? *options_.known : prior_mean_response());
}

// Where light is unsteady, what was fitted is not what a stated exposure is off, but a frame's own.
ResponseEstimate ResponseLearner::of_stated(ResponseEstimate estimate, std::span<const CompactFrame> frames,
                                            std::span<const float> light) const {
  if (!unsteady_) return estimate;
  for (std::size_t i = 0; i < light.size(); ++i) {
    const float stated = frames[i].exposure();
    estimate.light.push_back(std::log(estimate.exposures.corrected(stated * std::exp(light[i])) / stated));
  }
  estimate.exposures = {};
  return estimate;
}

std::optional<ResponseEstimate> ResponseLearner::next(const ExposedFrame& frame, const NoiseModel& noise) {
  constexpr double kFarMoreCertain = 0.5;
  constexpr double kCertain = 0.05;  // ln x: what is left is not what more frames would tell
  if (options_.model != ResponseModel::Curve || uncertainty_ <= kCertain) return {};
  const long now = frames_++;
  if (now < look_at_) return {};
  const auto gathered = static_cast<int>(window_.size());
  if (!fit_.valid() && gathered < options_.frames) {
    window_.emplace_back(frame, options_.bits);
    if (gathered + 1 == options_.frames)
      fit_ = started([this, noise] {
        look(window_, light_of(window_), SceneCuts::Possible);
        return of_stated(estimator_.estimate(noise, options_.model), {}, {});
      });
    return {};
  }
  if (now < look_at_ + 3 * options_.frames)
    return {};  // as long as it may take where frames come at their rate
  ResponseEstimate found = fit_.get();
  window_.clear();
  look_at_ = now + pause_after(now, options_.frames);
  const double uncertainty = uncertainty_of(found.response);
  if (!is_measured(found) || uncertainty > kFarMoreCertain * uncertainty_) return {};
  measured_ = true, uncertainty_ = uncertainty;
  return found;
}

// By what two exposures show alike, or by the sensor's own noise; but not where that left the mean of real
// cameras as uncertain as it is: the noise of dark frames matches, too.
bool ResponseLearner::is_measured(const ResponseEstimate& estimate) const {
  constexpr double kNothingLearned = 0.35;  // ln x; the mean has .38
  const bool told =
      options_.model != ResponseModel::Curve || uncertainty_of(estimate.response) < kNothingLearned;
  return told && (estimator_.pairs() > 0 || estimate.noise);
}

// At frames in a row. light: ln, of each; none where it is steady.
void ResponseLearner::look(std::span<const CompactFrame> frames, std::span<const float> light,
                           SceneCuts cuts) {
  unsteady_ = unsteady_ || !light.empty();
  ExposedFrame before, frame;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    frames[i].restore(frame);
    if (!light.empty()) frame.exposure *= std::exp(light[i]);
    if (cuts == SceneCuts::Possible) estimator_.add_noise(frame);
    if (i > 0) estimator_.add_pair(before, frame, cuts);
    std::swap(before, frame);
  }
}

}  // namespace hdrcam
