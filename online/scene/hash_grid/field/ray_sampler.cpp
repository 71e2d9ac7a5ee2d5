#include "online/scene/hash_grid/field/ray_sampler.h"

#include <cmath>

namespace hdrcam {
namespace {

constexpr float kLostFlow = 0.5f;     // interest of a disoccluded pixel, of a clipped one's
constexpr float kOfMisfit = 0.5f;     // share of the focus that goes by misfit, the rest by interest
constexpr float kLearning = 0.1f;     // of a tile's misfit by a new one
constexpr float kLeastTotal = 1e-6f;  // of interest or misfit, where no tile has any

}  // namespace

PixelPicker::PixelPicker(int rows, int cols)
    : rows_(rows),
      cols_(cols),
      tile_rows_((rows + kTile - 1) / kTile),
      tile_cols_((cols + kTile - 1) / kTile) {
  const auto tiles = static_cast<std::size_t>(tile_rows_) * static_cast<std::size_t>(tile_cols_);
  interest_.assign(tiles, 0);
  misfit_.assign(tiles, 0);
  cumulative_.assign(tiles, 0);
}

void PixelPicker::look_at(const WindowFrame& frame) {
  std::fill(interest_.begin(), interest_.end(), 0.f);
  constexpr auto kBackward = static_cast<std::size_t>(kBaseConfidence) + 1;
  const bool knows_flow = frame.knows_flow(Neighbour::Previous);
  for (int y = 0; y < rows_; ++y)
    for (int x = 0; x < cols_; ++x) {
      const BasePixel& base = frame.base.at(0, y, x);
      const float lost = knows_flow ? 1 - base[kBackward] : 0;
      interest_[tile_of(x, y)] += (mean_gate(base.data()) + kLostFlow * lost) / (kTile * kTile);
    }
}

void PixelPicker::learn(int x, int y, float misfit) {
  if (!std::isfinite(misfit)) return;
  float& tile = misfit_[tile_of(x, y)];
  tile += kLearning * (misfit - tile);
}

void PixelPicker::prepare(float uniform_share) {
  float interest = 0, misfit = 0;
  for (std::size_t i = 0; i < interest_.size(); ++i) interest += interest_[i], misfit += misfit_[i];
  const auto tiles = static_cast<float>(interest_.size());
  float sum = 0;
  for (std::size_t i = 0; i < interest_.size(); ++i) {
    const float focus = (1 - kOfMisfit) * interest_[i] / std::max(interest, kLeastTotal) +
                        kOfMisfit * misfit_[i] / std::max(misfit, kLeastTotal);
    sum += uniform_share / tiles + (1 - uniform_share) * focus;
    cumulative_[i] = sum;
  }
}

PixelPicker::Pixel PixelPicker::pick(Pcg32& random) const {
  const float at = random.uniform() * cumulative_.back();
  const auto tile = std::min<std::ptrdiff_t>(
      std::upper_bound(cumulative_.begin(), cumulative_.end(), at) - cumulative_.begin(),
      static_cast<std::ptrdiff_t>(cumulative_.size()) - 1);
  const int x = std::min(static_cast<int>(tile) % tile_cols_ * kTile + random.below(kTile), cols_ - 1);
  const int y = std::min(static_cast<int>(tile) / tile_cols_ * kTile + random.below(kTile), rows_ - 1);
  return {x, y};
}

}  // namespace hdrcam
