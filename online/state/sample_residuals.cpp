#include "online/state/sample_residuals.h"

#include <algorithm>
#include <cmath>

#include "hal/core/median.h"
#include "hal/core/robust_spread.h"
#include "online/state/pass_constants.h"

namespace hdrcam {
namespace {

// Chosen, not measured: their standard deviation is known within 1 / sqrt(2 n) = 11 %, outliers aside.
constexpr std::size_t kEnough = 40;  // residuals of a bin
constexpr float kLearning = 0.3f;    // share of a new frame in its slot's average

}  // namespace

SampleResiduals::SampleResiduals() {
  for (auto& channel : bins_)
    for (Bin& bin : channel) bin.residuals.reserve(Bin::kCapacity), bin.predicted.reserve(Bin::kCapacity);
}

void SampleResiduals::Bin::add(float residual, float variance) {
  std::size_t place = seen++;
  if (place < kCapacity) {
    residuals.push_back(residual), predicted.push_back(variance);
    return;
  }
  constexpr std::size_t kSpread = 2654435761u;  // Knuth's multiplicative hash: 2^32 over the golden ratio
  place = place * kSpread % seen;               // takes the place of an earlier one, or is left out
  if (place < kCapacity) residuals[place] = residual, predicted[place] = variance;
}

int SampleResiduals::slot_of(float exposure) {
  return static_cast<int>(std::lround(2 * std::log2(exposure)));
}

void SampleResiduals::observe(const Seen& predicted, const Image<float>& confidence, WorkerPool& pool) {
  begin();
  VarianceExcess& slot = excess_[slot_of(predicted.tables.exposure())];
  pool.for_each(3, [&](int channel) {
    take_all(channel, predicted, confidence);
    learn(static_cast<std::size_t>(channel), slot);
  });
}

void SampleResiduals::take_all(int c, const Seen& predicted, const Image<float>& confidence) {
  const auto& [state, samples, tables, unseen_variance] = predicted;
  const ResidualSampling how = kResidualSampling;
  const float exposure2 = tables.exposure() * tables.exposure();
  const int rows = state.radiance.rows(), cols = state.radiance.cols();
  for (int y = 1, step = how.line_step_px(rows, cols); y < rows - 1; y += step) {
    const float *s = state.radiance.row(c, y), *v = state.variance.row(c, y);
    const float *up = state.radiance.row(c, y - 1), *down = state.radiance.row(c, y + 1);
    const float *r = samples.radiance.row(c, y), *w = samples.weight.row(c, y);
    const float* blur = samples.blur_row(c, y);
    const float* trust = confidence.row(0, y);
    for (int x = 1; x < cols - 1; x += how.stride_px) {
      if (trust[x] < how.least_confidence || v[x] >= unseen_variance || w[x] < pass_constants::kUnclipped)
        continue;
      const float variance = tables.variance(c, s[x]) + v[x];
      const float slope_x = s[x + 1] - s[x - 1], slope_y = down[x] - up[x];
      const float misplaced = how.misalignment * (slope_x * slope_x + slope_y * slope_y);
      if (misplaced > variance + how.relative * how.relative * s[x] * s[x]) continue;
      const float x_seen = s[x] * tables.exposure();
      const float place = VarianceExcess::place_of(x_seen);
      const auto bin = static_cast<int>(static_cast<double>(place) + 0.5);  // to the nearest, without a call
      take(c, bin, (r[x] - s[x] - (blur != nullptr ? blur[x] : 0)) * tables.exposure(),
           variance * exposure2 - tables.excess().at_place(static_cast<std::size_t>(c), place));
    }
  }
}

void SampleResiduals::begin() {
  for (auto& channel : bins_)
    for (Bin& bin : channel) bin.residuals.clear(), bin.predicted.clear(), bin.seen = 0;
}

void SampleResiduals::learn(float exposure) {
  VarianceExcess& slot = excess_[slot_of(exposure)];
  for (std::size_t c = 0; c < 3; ++c) learn(c, slot);
}

void SampleResiduals::learn(std::size_t channel, VarianceExcess& slot) {
  for (std::size_t k = 0; k < VarianceExcess::kBins; ++k) {
    Bin& bin = bins_[channel][k];
    if (bin.residuals.size() < kEnough) continue;
    const Spread spread = robust_spread(bin.residuals);
    const double seen = spread.centre * spread.centre + spread.variance;
    const auto excess = static_cast<float>(std::max(0.0, seen - static_cast<double>(median(bin.predicted))));
    slot.bins[channel][k] += kLearning * (excess - slot.bins[channel][k]);
  }
}

const VarianceExcess& SampleResiduals::excess(float exposure) const {
  static const VarianceExcess kNone;
  const auto found = excess_.find(slot_of(exposure));
  return found == excess_.end() ? kNone : found->second;
}

}  // namespace hdrcam
