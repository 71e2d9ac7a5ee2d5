#include "online/sensor_model.h"

#include <cmath>

#include "capture/amplified_noise.h"
#include "capture/companding.h"
#include "capture/to_exposed_frame.h"

namespace hdrcam {
namespace {

// Of the quantiser, in codes of 255. Companded, steps of the quantiser are even in light, as read noise is.
float code_step_of(const CameraFacts& camera) { return is_companded(camera) ? 0 : code_scale(camera.bits); }

// Of codes of which white is not the largest, black removed and the range stretched again to 255.
// camera_black: in these codes.
Response below_white(const Response& response, const BlackLevel& black, const BlackLevel& camera_black,
                     const WhiteLevel& white) {
  std::array<Response::Curve, 3> inverse{}, uncertainty{};
  for (std::size_t c = 0; c < inverse.size(); ++c) {
    const float stretch = kMaxCode / white[c] * (kMaxCode - camera_black[c]) / (kMaxCode - black[c]);
    const auto channel = static_cast<int>(c);
    for (std::size_t z = 0; z < inverse[c].size(); ++z) {
      const float code = std::min(kMaxCode, stretch * static_cast<float>(z));
      inverse[c][z] = response.exposure_of(channel, code);
      uncertainty[c][z] = response.uncertainty(channel, code);
    }
  }
  return Response(inverse, uncertainty);
}

// ln, of the frame that comes so many after the first; none behind the first ones.
std::optional<float> light_of(const std::vector<float>& first_light, int age) {
  const auto place = static_cast<std::size_t>(age);
  return place < first_light.size() ? std::optional(first_light[place]) : std::nullopt;
}

}  // namespace

SensorModel::SensorModel(const Knobs& knobs, const CameraFacts& camera,
                         const std::optional<Response>& response, const StateLayer& state, WorkerPool& pool)
    : noise_kind_(knobs.noise),
      blur_kind_(knobs.motion_blur),
      light_kind_(knobs.light),
      response_stated_(response.has_value()),
      state_(state),
      pool_(pool),
      learner_({.model = knobs.response,
                .frames = knobs.bootstrap_frames,
                .code_step = code_step_of(camera),
                .bits = camera.bits,
                .light_may_change = knobs.light == LightKind::Followed,
                .known = response}),
      response_(response ? *response : prior_mean_response()),
      noise_estimator_(std::in_place, pool),
      texture_error_of_mosaic_(is_bayer(camera.layout) ? kTextureErrorOfMosaic : 0),
      texture_error_(std::in_place, pool, texture_error_of_mosaic_),
      shown_blur_(pool) {
  noise_.code_noise = camera.linear ? 0 : knobs.code_noise;  // raw codes are not compressed
  noise_.code_step = code_step_of(camera);
  assumed_noise_ = noise_;
  if (is_companded(camera)) own_response_ = Response::linear();
}

void SensorModel::meet(const ExposedFrame& frame) {
  constexpr std::size_t kMaxTables = 32;
  if (tables_.size() > kMaxTables) tables_.clear();
  if (reference_gain_ == 0) {
    reference_gain_ = frame.facts.gain();
    white_level_ = frame.white;
    if (response_stated_) black_level_ = frame.facts.black_level.value_or(BlackLevel());  // as it was removed
  }
  if (blur_kind_ == BlurKind::Shown) shown_blur_.observe_exposure(frame);
}

void SensorModel::learn_first(std::span<const CompactFrame> frames) {
  known_ = true;
  go_over_to(learner_.first(frames, noise_, pool_));
}

std::optional<ResponseEstimate> SensorModel::learn_response(const ExposedFrame& frame) {
  if (response_stated_) return std::nullopt;
  return learner_.next(frame, noise_);
}

void SensorModel::begin_anew(const ResponseEstimate& estimate, int frame) {
  relearned_.push_back(frame);
  begun_with_ = frame;
  tables_.clear();
  noise_ = assumed_noise_;
  noise_estimator_.emplace(pool_);
  texture_error_.emplace(pool_, texture_error_of_mosaic_);
  shown_blur_.forget();
  go_over_to(estimate);
}

void SensorModel::go_over_to(const ResponseEstimate& estimate) {
  response_ = estimate.response;
  if (!response_stated_) black_level_ = estimate.black_level;
  if (!white_level_.is_largest_code())
    own_response_ = below_white(response_, black_level_, camera_black_level(), white_level_);
  neutral_gains_ = estimate.neutral_gains;
  exposures_ = estimate.exposures;
  first_light_ = estimate.light;
  if (!first_light_.empty()) frame_light_.expect_unsteady();
  noise_origin_ = NoiseOrigin::Unknown;
  if (!estimate.noise || noise_kind_ != NoiseKind::Learned) return;
  noise_origin_ = NoiseOrigin::Sensor;
  noise_ = *estimate.noise;
  noise_estimator_->expect(noise_);
}

void SensorModel::correct(ExposedFrame& frame) const {
  if (!response_stated_) remove_black_level(frame, black_level_);
  frame.exposure = exposures_.corrected(frame.exposure);
  if (const auto light = light_of(first_light_, frame.index - begun_with_))
    frame.exposure *= std::exp(*light);
}

BlackLevel SensorModel::camera_black_level() const {
  BlackLevel black;
  for (std::size_t c = 0; c < 3; ++c) black.set(c, black_level_[c] * (white_level_[c] / kMaxCode));
  return black;
}

float SensorModel::count_blur(ExposedFrame& frame) const {
  const float stated = ShownBlur::stated(frame);
  switch (blur_kind_) {
    case BlurKind::Off:
      frame.blur_fraction = 0;
      break;
    case BlurKind::Stated:
      frame.blur_fraction = stated;
      break;
    case BlurKind::Shown:
      frame.blur_fraction = shown_blur_.counted(stated);
      break;
  }
  return stated;
}

void SensorModel::compare(const ExposedFrame& frame, float stated, const FlowField& motion,
                          float unseen_variance) {
  const StateComparison compared{frame, state_.state(), motion, tables_for(frame), unseen_variance};
  if (blur_kind_ == BlurKind::Shown && looks_closely(frame)) shown_blur_.observe(compared, stated);
  if (noise_kind_ == NoiseKind::Assumed) return;
  texture_error_->observe(compared);
  for (auto& [key, tables] : tables_) tables.set_texture_error(texture_error_->share());
}

void SensorModel::follow_light(ExposedFrame& frame, const FlowField& motion, float unseen_variance) {
  if (light_kind_ == LightKind::Steady || light_of(first_light_, frame.index - begun_with_)) return;
  const float light =
      frame_light_.follow({frame, state_.state(), motion, tables_for(frame), unseen_variance});
  if (light != 0) frame.exposure *= std::exp(light);
}

// Whether a frame tells of noise and blur: every one at first, a fifth of them later, so that each pair of a
// cycle of four has its turn, and a frame later after five of these, for cycles of five.
bool SensorModel::looks_closely(const ExposedFrame& frame) const {
  constexpr int kEagerFrames = 24, kLaterEvery = 5;
  const int age = frame.index - begun_with_;
  return age < kEagerFrames || (age - age / (kLaterEvery * kLaterEvery)) % kLaterEvery == 0;
}

bool SensorModel::learns_noise(const ExposedFrame& frame) const {
  return noise_kind_ == NoiseKind::Learned && looks_closely(frame);
}

void SensorModel::learn_noise(const ExposedFrame& older, const ExposedFrame& newer,
                              const StateMotion& motion) {
  constexpr int kEager = 8;  // pairs: at first the model is solved with each, then with multiples of this
  if (noise_is_seen_in_newer(older, newer))
    noise_estimator_->add_pair(newer, older, motion.to_previous, response_, {gain_of(newer), gain_of(older)});
  else
    noise_estimator_->add_pair(older, newer, motion.from_previous, response_,
                               {gain_of(older), gain_of(newer)});
  if (noise_estimator_->pairs() >= kEager && noise_estimator_->pairs() % kEager != 0) return;
  noise_ = noise_estimator_->solve(assumed_noise_);
  for (auto& [key, tables] : tables_) tables = tables_at(key);
}

void SensorModel::take_over_residuals(const ExposedFrame& frame) {
  const ExposureAndGain key{frame.exposure, gain_of(frame)};
  tables_.insert_or_assign(key, tables_at(key));
}

float SensorModel::gain_of(const ExposedFrame& frame) const {
  return static_cast<float>(frame.facts.gain() / reference_gain_);
}

ExposureTables SensorModel::tables_at(const ExposureAndGain& at) const {
  const auto& [exposure, gain] = at;
  ExposureTables tables(response_, amplified(noise_, gain), exposure, state_.residuals().excess(exposure));
  tables.set_texture_error(texture_error_->share());
  return tables;
}

const ExposureTables& SensorModel::tables_for(const ExposedFrame& frame) {
  const ExposureAndGain key{frame.exposure, gain_of(frame)};
  const auto found = tables_.find(key);
  return found != tables_.end() ? found->second : tables_.emplace(key, tables_at(key)).first->second;
}

}  // namespace hdrcam
