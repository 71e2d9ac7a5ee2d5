#include "online/response/noise_levels.h"

#include <algorithm>
#include <cmath>

#include "capture/clip_policy.h"
#include "capture/to_exposed_frame.h"
#include "hal/core/median.h"

namespace hdrcam {
namespace {

constexpr int kTile = 8, kCell = 4;  // pixels; contrast is measured between cells
constexpr int kAround = 4;           // pixels around a tile that belong to its surroundings
constexpr int kMostTiles = 2400;     // of a frame; larger pictures are sampled
constexpr std::size_t kEnoughTiles = 16 * std::size_t{kMostTiles};  // of a brightness
constexpr float kFirstEdge = 2, kEdgeRatio = 1.16f;                 // of the bins, codes

std::optional<std::size_t> bin_of(float code, std::size_t bins) {
  if (code < kFirstEdge) return {};
  const auto bin = static_cast<std::size_t>(std::log(code / kFirstEdge) / std::log(kEdgeRatio));
  return bin < bins ? std::optional(bin) : std::nullopt;
}

// What a pixel's neighbours do not predict: of a plane of light nothing, of white noise all (Immerkaer 1996).
float detail(const float* above, const float* row, const float* below, int x) {
  return (above[x - 1] + above[x + 1] + below[x - 1] + below[x + 1] -
          2 * (above[x] + row[x - 1] + row[x + 1] + below[x]) + 4 * row[x]) *
         (1 / 6.f);
}

using Details = std::array<float, kTile * kTile>;

Details details_of(const Image<float>& codes, int channel, int y0, int x0) {
  Details details;
  std::size_t i = 0;
  for (int y = y0; y < y0 + kTile; ++y)
    for (int x = x0; x < x0 + kTile; ++x)
      details[i++] = detail(codes.row(channel, y - 1), codes.row(channel, y), codes.row(channel, y + 1), x);
  return details;
}

// The variance of the details at half the size, for white noise that of the details.
float coarse_variance(const Image<float>& codes, int channel, int y0, int x0) {
  constexpr int kHalf = kTile / 2 + 2;  // with a margin
  std::array<std::array<float, kHalf>, kHalf> half;
  for (int y = 0; y < kHalf; ++y)
    for (int x = 0; x < kHalf; ++x) {
      const float* a = codes.row(channel, y0 + 2 * y - 2) + x0 + 2 * x - 2;
      const float* b = codes.row(channel, y0 + 2 * y - 1) + x0 + 2 * x - 2;
      half[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)] = (a[0] + a[1] + b[0] + b[1]) / 4;
    }
  float sum = 0;
  for (std::size_t y = 1; y + 1 < kHalf; ++y)
    for (int x = 1; x + 1 < kHalf; ++x) {
      const float d = detail(half[y - 1].data(), half[y].data(), half[y + 1].data(), x);
      sum += d * d;
    }
  return 4 * sum / ((kHalf - 2) * (kHalf - 2));
}

float mean_product(const Details& a, const Details& b) {
  float sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum / static_cast<float>(a.size());
}

// Range of the means of cells in the tile and around it.
float contrast_around(const Image<float>& codes, int channel, int y0, int x0) {
  float least = kMaxCode, most = 0;
  for (int y = y0 - kAround; y < y0 + kTile + kAround; y += kCell)
    for (int x = x0 - kAround; x < x0 + kTile + kAround; x += kCell) {
      float sum = 0;
      for (int dy = 0; dy < kCell; ++dy)
        for (int dx = 0; dx < kCell; ++dx) sum += codes.at(channel, y + dy, x + dx);
      least = std::min(least, sum / (kCell * kCell)), most = std::max(most, sum / (kCell * kCell));
    }
  return most - least;
}

float lower_quartile(std::vector<float>& values) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 4);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace

struct NoiseLevels::Bin {
  float code, variance;
  float shared;  // of the variance, with the channel that has most of it
  float coarse;  // deviation at half the size over that at full size: 1 for white noise
  std::size_t tiles;
};

NoiseLevels::NoiseLevels(float code_step, int bits)
    : code_step_(code_step), least_variance_(code_scale(bits) * code_scale(bits) / 4) {}

void NoiseLevels::add(const ExposedFrame& frame) {
  constexpr float kSameGain = 0.01f;
  if ((frame.facts.flags & kFrameDamaged) != 0) return;
  const auto gain = static_cast<float>(frame.facts.gain());
  if (gain_ == 0) gain_ = gain;
  if (std::abs(gain - gain_) > kSameGain * gain_) return;
  const int rows = (frame.codes.rows() - 2 * kAround) / kTile,
            cols = (frame.codes.cols() - 2 * kAround) / kTile;
  if (rows <= 0 || cols <= 0) return;
  const int count = rows * cols, step = (count + kMostTiles - 1) / kMostTiles;
  for (int i = frame.index % step; i < count; i += step)
    add_tile(frame.codes, kAround + i / cols * kTile, kAround + i % cols * kTile);
}

void NoiseLevels::add_tile(const Image<float>& codes, int y0, int x0) {
  const auto [darkest, brightest] = clip_policy::kNoiseTile;
  std::array<Details, 3> details;
  std::array<float, 3> variance{};
  for (std::size_t c = 0; c < 3; ++c) {
    details[c] = details_of(codes, static_cast<int>(c), y0, x0);
    variance[c] = mean_product(details[c], details[c]);
  }
  for (std::size_t c = 0; c < 3; ++c) {
    const int channel = static_cast<int>(c);
    float sum = 0, least = kMaxCode, most = 0;
    for (int y = y0; y < y0 + kTile; ++y)
      for (int x = x0; x < x0 + kTile; ++x) {
        const float code = codes.at(channel, y, x);
        sum += code, least = std::min(least, code), most = std::max(most, code);
      }
    const float mean = sum / (kTile * kTile);
    const auto bin = bin_of(mean, kBins);
    if (least <= darkest || most >= brightest || !bin || tiles_[c][*bin].size() >= kEnoughTiles) continue;
    const std::size_t p = (c + 1) % 3, q = (c + 2) % 3;
    tiles_[c][*bin].push_back({mean,
                               contrast_around(codes, channel, y0, x0),
                               variance[c],
                               coarse_variance(codes, channel, y0, x0),
                               {mean_product(details[c], details[p]), mean_product(details[c], details[q])},
                               {variance[p], variance[q]}});
  }
}

// What the tiles with the least contrast show; none where they are too few or their noise is below what a
// code resolves.
std::optional<NoiseLevels::Bin> NoiseLevels::flattest(std::vector<Tile> tiles) const {
  constexpr std::size_t kLeastTiles = 24, kLeastFlat = 12;
  constexpr float kFlatShare = 0.2f;  // of the tiles
  if (tiles.size() < kLeastTiles) return {};
  const auto flat =
      std::max(kLeastFlat, static_cast<std::size_t>(kFlatShare * static_cast<float>(tiles.size())));
  std::nth_element(tiles.begin(), tiles.begin() + static_cast<std::ptrdiff_t>(flat), tiles.end(),
                   [](const Tile& a, const Tile& b) { return a.contrast < b.contrast; });
  tiles.resize(flat);
  const auto median_of = [&](float Tile::*of) {
    std::vector<float> values;
    values.reserve(flat);
    for (const Tile& tile : tiles) values.push_back(tile.*of);
    return median(values);
  };
  Bin bin{0, median_of(&Tile::variance), 0, 0, flat};
  if (!(bin.variance > least_variance_)) return {};
  bin.coarse = std::sqrt(median_of(&Tile::coarse) / bin.variance);
  for (const Tile& tile : tiles) bin.code += tile.code / static_cast<float>(flat);
  for (std::size_t k = 0; k < 2; ++k) {
    float shared = 0, own = 0, other = 0;
    for (const Tile& tile : tiles) shared += tile.shared[k], own += tile.variance, other += tile.other[k];
    if (other > 0) bin.shared = std::max(bin.shared, std::abs(shared) / std::sqrt(own * other));
  }
  return bin;
}

std::array<std::vector<NoiseLevel>, 3> NoiseLevels::levels() const {
  constexpr std::size_t kLeastBins = 6;
  // Compression and demosaicing share .7 of the variance and more between channels; what filters leave is two
  // to six times as large at half the size. Textures do either here and there.
  constexpr float kMostUsuallyShared = 0.5f, kMostUsuallyCoarse = 1.55f;  // median, quartile
  constexpr float kMostShared = 0.4f, kLeastCoarse = 0.75f;               // of a level
  constexpr float kError = 0.06f;                                         // of ln spread
  constexpr float kOfTile = 60;  // twice the independent details of a tile
  std::array<std::vector<NoiseLevel>, 3> levels;
  std::vector<float> shared, coarse;
  const float quantised = code_step_ * code_step_ / 12;
  for (std::size_t c = 0; c < 3; ++c)
    for (const std::vector<Tile>& tiles : tiles_[c]) {
      const std::optional<Bin> bin = flattest(tiles);
      if (!bin) continue;
      shared.push_back(bin->shared), coarse.push_back(bin->coarse);
      const float own = bin->variance * (1 - bin->shared) - quantised;
      if (bin->shared > kMostShared || bin->coarse < kLeastCoarse || own < quantised) continue;
      const float error2 =
          kError * kError + bin->shared * bin->shared / 4 + 1 / (kOfTile * static_cast<float>(bin->tiles));
      levels[c].push_back({bin->code, std::sqrt(own), std::sqrt(error2)});
    }
  if (shared.size() < kLeastBins || median(shared) > kMostUsuallyShared ||
      lower_quartile(coarse) > kMostUsuallyCoarse)
    return {};
  return levels;
}

}  // namespace hdrcam
