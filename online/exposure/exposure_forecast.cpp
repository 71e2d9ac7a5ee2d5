#include "online/exposure/exposure_forecast.h"

#include <algorithm>
#include <cmath>

#include "capture/amplified_noise.h"
#include "capture/clip_policy.h"
#include "hal/core/smooth_step.h"
#include "online/mu_law.h"

namespace hdrcam {
namespace {

constexpr float kNoSample = 1e9f;      // variance of a clipped sample
constexpr float kLeastWeight = 0.01f;  // of a sample that fades towards clipping: below it counts as clipped

}  // namespace

void ExposureForecast::look(const ScenePixels& pixels, const Sensor& sensor, double reference_exposure,
                            float white) {
  pixels_ = &pixels;
  noise_ = sensor.noise;
  reference_exposure_ = reference_exposure, reference_gain_ = sensor.reference_gain;
  constexpr float kNoShotNoise = 1e9f;  // electrons
  NoiseModel coded = sensor.noise;
  coded.full_well = kNoShotNoise, coded.read_noise = 0;
  if (tables_)
    tables_->rebuild(sensor.response, coded);
  else
    tables_.emplace(sensor.response, coded, 1.f);
  const float scale = kPsnrMu / std::log(1 + kPsnrMu) / white;
  for (std::size_t i = 0; i < weight_.size(); ++i) {
    const float bright = pixels.radiance()[i] / white;
    const float slope = bright > 1 ? 0 : scale / (1 + kPsnrMu * bright);
    weight_[i] = slope * slope;
  }
}

void ExposureForecast::sample_variances(const Exposure& exposure, Blur blur, Values& variances) const {
  const auto relative = static_cast<float>(exposure.product() / reference_exposure_);
  const NoiseModel noise = amplified(noise_, static_cast<float>(exposure.gain / reference_gain_));
  const auto& radiance = pixels_->radiance();
  // the blur of this time lies between those of two lengths
  const double octave = std::log2(pixels_->interval_s() / to_seconds(exposure.time));
  const auto place = static_cast<float>(std::clamp(octave, 0.0, ScenePixels::kLengths - 1.001));
  const auto length = static_cast<int>(place);
  const float between = place - static_cast<float>(length);
  const Values &longer = pixels_->squared_blur(length), &shorter = pixels_->squared_blur(length + 1);
  const float counted = blur == Blur::Counted ? 1 : 0;
  for (std::size_t i = 0; i < variances.size(); ++i) {
    const int c = pixels_->channel(static_cast<int>(i));
    const float x = radiance[i] * relative;
    const float weight = 1 - smooth_step(clip_policy::kFadeBegin, clip_policy::kFadeEnd, tables_->code(c, x));
    const float own = (tables_->variance(c, x) + noise.exposure_variance(x)) / (relative * relative);
    const float smear = longer[i] + (shorter[i] - longer[i]) * between;
    const float doubt = state_.fusion.relative_noise * radiance[i];
    variances[i] = weight > kLeastWeight ? (own + doubt * doubt + counted * smear) / weight : kNoSample;
  }
}

double ExposureForecast::error(std::span<const Values* const> slots) const {
  constexpr int kRounds = 3;        // of the cycle; the last one counts
  constexpr float kUnknown = 0.5f;  // of radiance: error of a pixel of which nothing is known
  constexpr float kLeastKept = 0.01f, kLeastVariance = 1e-12f;  // they keep quotients finite
  const float growth = 1 + state_.variance_growth,
              relative2 = state_.relative_growth * state_.relative_growth;
  const std::size_t count = slots.size();
  const Values &radiance = pixels_->radiance(), &misalignment = pixels_->misalignment(),
               &kept = pixels_->kept();
  Values carried, sum{};
  for (std::size_t i = 0; i < carried.size(); ++i)
    carried[i] = kUnknown * radiance[i] * kUnknown * radiance[i];
  for (int round = 0; round < kRounds; ++round)
    for (std::size_t s = 0; s < count; ++s) {
      const Values &now = *slots[s], &next = *slots[(s + 1) % count];
      const float counts = round == kRounds - 1 ? 1 : 0;
      for (std::size_t i = 0; i < carried.size(); ++i) {
        const float most = kUnknown * radiance[i] * kUnknown * radiance[i] + kLeastVariance;
        const float drift = relative2 * radiance[i] * radiance[i] + misalignment[i];
        const float predicted = std::min(most, (carried[i] * growth + drift) / std::max(kLeastKept, kept[i]));
        const float updated = predicted * now[i] / (predicted + now[i]);
        // the look-ahead: the next frame's sample, moved here
        const float later = (next[i] + drift) / std::max(kLeastKept, kept[i]);
        sum[i] += counts * updated * later / (updated + later);
        carried[i] = updated;
      }
    }
  double total = 0;
  // what no exposure mends, such as the response's error: of radiance, whatever is averaged
  const float lasting2 = state_.fusion.relative_noise * state_.fusion.relative_noise;
  const auto phases = static_cast<float>(count);
  for (std::size_t i = 0; i < sum.size(); ++i)
    total += static_cast<double>((sum[i] + phases * lasting2 * radiance[i] * radiance[i]) * weight_[i]);
  return total / static_cast<double>(sum.size() * count);
}

double ExposureForecast::error(std::span<const Exposure> cycle, Blur blur) {
  std::array<const Values*, ExposureSchedule::kMaxSlots> slots{};
  for (std::size_t s = 0; s < cycle.size(); ++s) {
    sample_variances(cycle[s], blur, variances_[s]);
    slots[s] = &variances_[s];
  }
  return error({slots.data(), cycle.size()});
}

}  // namespace hdrcam
