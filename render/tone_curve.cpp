#include "render/tone_curve.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "hal/core/quantile.h"
#include "render/srgb.h"

namespace hdrcam {
namespace {

constexpr int kMeasureStep_px = 3;  // a ninth of the pixels suffices for a mean and a percentile
constexpr double kWhitePercentile = 0.995;
// Half a stop above the percentile, so that highlights keep their shape.
constexpr float kWhiteHeadroom = 1.41f;
constexpr float kLeastContrast = 4;  // white / mid: a flat picture is not stretched to the full display range

float moved_towards(float from, float to, float most_stops) {
  const float stops = std::log2(to / from);
  return from * std::exp2(std::clamp(stops, -most_stops, most_stops));
}

}  // namespace

std::optional<ToneAnchors> tone_anchors(const Image<float>& radiance) {
  std::vector<float> luminances;
  double log_sum = 0;
  for (int y = 0; y < radiance.rows(); y += kMeasureStep_px) {
    const float *r = radiance.row(0, y), *g = radiance.row(1, y), *b = radiance.row(2, y);
    for (int x = 0; x < radiance.cols(); x += kMeasureStep_px) {
      const float light = luminance(r[x], g[x], b[x]);
      if (!(light > 0) || !std::isfinite(light)) continue;
      luminances.push_back(light);
      log_sum += std::log(light);
    }
  }
  if (luminances.empty()) return std::nullopt;
  const float high = quantile(std::span(luminances), kWhitePercentile);
  const auto mean = static_cast<float>(std::exp(log_sum / static_cast<double>(luminances.size())));
  const float mid = std::clamp(mean, 0x1p-20f, 0x1p20f);
  return ToneAnchors{mid, std::clamp(high * kWhiteHeadroom, kLeastContrast * mid, 0x1p24f)};
}

ToneCurve::ToneCurve(ToneAnchors anchors) : anchors_(anchors) {
  const float scale = kKey / anchors.mid;
  const float white = scale * anchors.white;
  for (std::size_t i = 0; i < codes_.size(); ++i) {
    const auto segment = static_cast<int>(i);
    const float radiance = std::ldexp(1 + static_cast<float>(segment % kSegments) / kSegments,
                                      segment / kSegments + kLowestOctave);
    const float x = scale * radiance;
    const float y = x * (1 + x / (white * white)) / (1 + x);
    codes_[i] = 255 * srgb_level(y);
  }
}

float ToneCurve::level(float radiance) const {
  if (!(radiance > 0)) return 0;
  // The exponent and the upper six bits of the mantissa are the segment, the lower bits the place within it.
  constexpr int kMantissaBits = std::numeric_limits<float>::digits - 1;
  constexpr int kPlaceBits = kMantissaBits - std::bit_width(unsigned{kSegments - 1});
  constexpr int kFirst = (kLowestOctave + std::numeric_limits<float>::max_exponent - 1) * kSegments;
  const auto bits = std::bit_cast<std::uint32_t>(radiance);
  const int segment = static_cast<int>(bits >> kPlaceBits) - kFirst;
  if (segment < 0) return 0;
  if (segment >= kSegments * kOctaves) return codes_.back();
  const float place =
      static_cast<float>(bits & ((1u << kPlaceBits) - 1)) / static_cast<float>(1u << kPlaceBits);
  const auto i = static_cast<std::size_t>(segment);
  return codes_[i] + place * (codes_[i + 1] - codes_[i]);
}

Image<std::uint8_t> tone_mapped(const Image<float>& radiance, const ToneCurve& curve) {
  Image<std::uint8_t> codes;
  codes.reshape(radiance.channels(), radiance.rows(), radiance.cols());
  std::transform(radiance.samples().begin(), radiance.samples().end(), codes.samples().begin(),
                 [&curve](float value) { return curve.code(value); });
  return codes;
}

const ToneCurve& ToneAdaptation::follow(const Image<float>& radiance) {
  const auto wanted = tone_anchors(radiance);
  if (!wanted) return curve_;
  const ToneAnchors held = curve_.anchors();
  curve_ = ToneCurve(measured_ ? ToneAnchors{moved_towards(held.mid, wanted->mid, kMaxStep),
                                             moved_towards(held.white, wanted->white, kMaxStep)}
                               : *wanted);
  measured_ = true;
  return curve_;
}

}  // namespace hdrcam
