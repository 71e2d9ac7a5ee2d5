#include "online/response/first_light.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "capture/exposure.h"
#include "hal/core/median.h"
#include "online/pictures/same_scene.h"

namespace hdrcam {
namespace {

struct FirstFrame {
  float log_exposure = 0;  // as stated
  SceneThumbnail thumbnail{};
};

std::vector<FirstFrame> small(std::span<const CompactFrame> frames) {
  std::vector<FirstFrame> all;
  std::vector<float> scratch;
  ExposedFrame frame;
  for (const CompactFrame& packed : frames) {
    packed.restore(frame);
    all.push_back({std::log(frame.exposure), quick_thumbnail_of(frame, scratch)});
  }
  return all;
}

// ln of the light of `after` over that of `before`; none where few cells show both.
std::optional<float> light_ratio(const SceneThumbnail& before, const SceneThumbnail& after,
                                 const Response& response) {
  constexpr float kDarkest = 8, kBrightest = 235;  // codes
  constexpr std::size_t kFew = 64;                 // cells of the channels
  const auto is_told = [](float code) { return code > kDarkest && code < kBrightest; };
  std::vector<float> ratios;
  for (std::size_t c = 0; c < before.size(); ++c)
    for (std::size_t i = 0; i < before[c].size(); ++i)
      if (is_told(before[c][i]) && is_told(after[c][i])) {
        const int channel = static_cast<int>(c);
        ratios.push_back(std::log(response.exposure_of(channel, after[c][i]) /
                                  response.exposure_of(channel, before[c][i])));
      }
  if (ratios.size() < kFew) return std::nullopt;
  return median(ratios);
}

// Of what changes on the way: a standard deviation.
float spread_of(const std::vector<float>& steps) {
  float sum = 0, squares = 0;
  for (const float step : steps) sum += step, squares += step * step;
  const auto count = static_cast<float>(steps.size());
  return std::sqrt(std::max(0.f, squares / count - sum * sum / (count * count)));
}

}  // namespace

std::vector<float> unsteady_light(std::span<const CompactFrame> frames, const Response& assumed) {
  constexpr float kUnsteady = 0.1f;  // ln; moving pictures have up to .06, lamps .12 and more
  constexpr std::size_t kFewSteps = 2;
  const std::vector<FirstFrame> all = small(frames);
  std::vector<float> light(all.size()), steps;
  std::vector<bool> is_done(all.size());
  for (std::size_t first = 0; first < all.size(); ++first) {
    if (is_done[first]) continue;
    std::vector<std::size_t> alike{first};
    float sum = 0;
    for (std::size_t i = first + 1; i < all.size(); ++i) {
      if (std::abs(all[i].log_exposure - all[first].log_exposure) > static_cast<float>(kSameExposure))
        continue;
      const std::size_t before = alike.back();
      const auto step = light_ratio(all[before].thumbnail, all[i].thumbnail, assumed);
      if (step) steps.push_back(*step);
      light[i] = light[before] + step.value_or(0);
      sum += light[i];
      alike.push_back(i);
      is_done[i] = true;
    }
    for (const std::size_t i : alike) light[i] -= sum / static_cast<float>(alike.size());
  }
  if (steps.size() < kFewSteps || spread_of(steps) < kUnsteady) return {};
  return light;
}

}  // namespace hdrcam
