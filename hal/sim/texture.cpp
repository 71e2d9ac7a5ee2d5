#include "hal/sim/texture.h"

#include <bit>
#include <cmath>
#include <numbers>

#include "hal/core/smooth_step.h"
#include "hal/sim/counter_random.h"
#include "hal/sim/value_noise.h"

namespace hdrcam {
namespace {

constexpr std::uint64_t kTintStream = 0x74696e74;

// Colour of the n-th element of a pattern, in stops around grey.
Colour tint(std::uint64_t seed, std::uint64_t n, float strength) {
  const CounterRandom random(seed, kTintStream, n);
  const auto channel = [&](std::uint64_t c) { return strength * random.uniform(c, -1, 1); };
  return {channel(0), channel(1), channel(2)};
}

// A pattern is log2 radiance as a function of the place in the tile, u and v in [0, 1).
struct Place {
  float u, v;
  std::uint64_t seed;
  std::uint32_t noise_seed;
};

Colour stone(Place p) {
  const float grain = fractal_noise(p.u, p.v, 4, 6, p.noise_seed);
  const float vein = fractal_noise(p.u, p.v, 4, 3, p.noise_seed + 17);
  return grey(1.7f * grain) + tint(p.seed, 0, 0.5f) * (1 + vein);
}

Colour tiles(Place p) {
  constexpr int kTiles = 8;
  constexpr float kJoint = 0.06f;
  const float x = p.u * kTiles, y = p.v * kTiles;
  const auto n =
      static_cast<std::uint64_t>(std::floor(y)) * kTiles + static_cast<std::uint64_t>(std::floor(x));
  const float edge =
      std::min(std::min(x - std::floor(x), std::ceil(x) - x), std::min(y - std::floor(y), std::ceil(y) - y));
  const float grain = fractal_noise(p.u, p.v, 16, 4, p.noise_seed);
  const float joint = smooth_step(kJoint / 2, kJoint, edge);
  return grey(0.7f * grain - 3 * (1 - joint)) + tint(p.seed, 0, 0.4f) + tint(p.seed, n + 1, 1) * joint;
}

// A dark wall whose windows are black or lit: nine stops in one picture.
Colour facade(Place p) {
  constexpr int kWindows = 5;
  const float x = p.u * kWindows, y = p.v * kWindows;
  const auto n =
      static_cast<std::uint64_t>(std::floor(y)) * kWindows + static_cast<std::uint64_t>(std::floor(x));
  const float fx = x - std::floor(x), fy = y - std::floor(y);
  const float grain = fractal_noise(p.u, p.v, 8, 5, p.noise_seed);
  const Colour wall = grey(-0.8f + 0.8f * grain) + tint(p.seed, 0, 0.5f);
  if (fx < 0.25f || fx > 0.75f || fy < 0.2f || fy > 0.8f) return wall;
  const bool lit = CounterRandom(p.seed, kTintStream, n + 1).uniform(7) < 0.3f;
  const bool bar = std::abs(fx - 0.5f) < 0.03f || std::abs(fy - 0.5f) < 0.03f;
  if (bar) return grey(-1.5f + 0.4f * grain);
  return lit ? grey(3.2f + 0.5f * grain) + Colour{0.4f, 0, -0.8f} : grey(-5 + 0.6f * grain);
}

Colour stripes(Place p) {
  const float wave = std::sin(2 * std::numbers::pi_v<float> * (6 * p.u + 2 * p.v));
  const float cross_wave = std::sin(2 * std::numbers::pi_v<float> * (5 * p.v - p.u));
  const float grain = fractal_noise(p.u, p.v, 8, 5, p.noise_seed);
  return grey(1.3f * wave * (0.6f + 0.4f * cross_wave) + 0.6f * grain) + tint(p.seed, wave > 0 ? 1 : 2, 0.8f);
}

// For numbers that an int holds; std::floor is a function call on machines that have no instruction for it.
int floor_of(float x) {
  const int truncated = static_cast<int>(x);
  return truncated - (x < static_cast<float>(truncated));
}

// Exact at powers of two and linear in between, which suffices for a mip level; x >= 1.
float rough_log2(float x) {
  const auto bits = std::bit_cast<std::uint32_t>(x);
  return static_cast<float>(bits) * 0x1p-23f - 127;
}

Colour pattern_at(Pattern pattern, Place p) {
  switch (pattern) {
    case Pattern::Stone:
      return stone(p);
    case Pattern::Tiles:
      return tiles(p);
    case Pattern::Facade:
      return facade(p);
    case Pattern::Stripes:
      break;
  }
  return stripes(p);
}

}  // namespace

Texture::Texture(Pattern pattern, std::uint64_t seed) {
  const auto noise_seed = static_cast<std::uint32_t>(CounterRandom(seed, kTintStream).bits(0));
  levels_[0].resize(kSide * kSide);
  float sum = 0;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const Place place{(static_cast<float>(x) + 0.5f) / kSide, (static_cast<float>(y) + 0.5f) / kSide, seed,
                        noise_seed};
      const Colour colour = exp2(pattern_at(pattern, place));
      levels_[0][static_cast<std::size_t>(y) * kSide + static_cast<std::size_t>(x)] = texel_of(colour);
      sum += luminance(colour);
    }
  for (Texel& texel : levels_[0]) texel *= kSide * kSide / sum;
  fill_levels();
}

Texture Texture::albedo() const {
  constexpr float kHalfWhite = 0.6f;
  Texture reflecting = *this;
  for (Texel& texel : reflecting.levels_[0]) texel /= texel + kHalfWhite;
  reflecting.fill_levels();
  return reflecting;
}

void Texture::fill_levels() {
  for (std::size_t level = 1; level < kLevels; ++level) {
    const std::size_t side = kSide >> level;
    const std::vector<Texel>& finer = levels_[level - 1];
    levels_[level].clear();
    for (std::size_t y = 0; y < side; ++y)
      for (std::size_t x = 0; x < side; ++x) {
        const Texel* corner = &finer[4 * y * side + 2 * x];
        levels_[level].push_back((corner[0] + corner[1] + corner[2 * side] + corner[2 * side + 1]) * 0.25f);
      }
  }
}

Texel Texture::bilinear(int level, float u, float v) const {
  const int side = kSide >> level, mask = side - 1;
  const float x = u * static_cast<float>(side) - 0.5f, y = v * static_cast<float>(side) - 0.5f;
  const int x_floor = floor_of(x), y_floor = floor_of(y);
  const float fx = x - static_cast<float>(x_floor), fy = y - static_cast<float>(y_floor);
  const int x0 = x_floor & mask, y0 = y_floor & mask, x1 = (x0 + 1) & mask, y1 = (y0 + 1) & mask;
  const Texel* texels = levels_[static_cast<std::size_t>(level)].data();
  const Texel* above = texels + y0 * side;
  const Texel* below = texels + y1 * side;
  const Texel top = above[x0] + fx * (above[x1] - above[x0]);
  const Texel bottom = below[x0] + fx * (below[x1] - below[x0]);
  return top + fy * (bottom - top);
}

Colour Texture::at(float u, float v, float covered) const {
  if (!(covered > 1)) return colour_of(bilinear(0, u, v));
  const float level = std::min(rough_log2(covered) / 2, kLevels - 1.001f);  // a level's texel covers four
  const int finer = static_cast<int>(level);
  const Texel fine = bilinear(finer, u, v), coarse = bilinear(finer + 1, u, v);
  return colour_of(fine + (level - static_cast<float>(finer)) * (coarse - fine));
}

}  // namespace hdrcam
