// Procedural HDR textures: radiance or albedo patterns that span many stops, generated from a seed, filtered
// for distance. Immutable after construction, so reentrant.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "hal/core/worker_pool.h"
#include "hal/sim/geometry.h"

namespace hdrcam {

enum class Pattern { Stone, Tiles, Facade, Stripes };

// A colour in one register; the fourth lane is unused.
using Texel = float __attribute__((vector_size(16)));
inline Texel texel_of(Colour c) { return Texel{c.x, c.y, c.z, 0}; }
inline Colour colour_of(Texel t) { return {t[0], t[1], t[2]}; }

// A tile that repeats in both directions without a seam, with a mip pyramid. As radiance its mean luminance
// is about 1.
class Texture {
 public:
  static constexpr int kSide = 256;  // texels
  Texture(Pattern pattern, std::uint64_t seed);

  // A surface of this pattern that reflects: 0..1, half of the light where the pattern's radiance is 0.6.
  // Filtered as what it reflects is, so that it is as bright from afar as from nearby.
  Texture albedo() const;

  // (u, v) in tiles; covered: how many texels of the finest level lie under one sample, for the filter.
  Colour at(float u, float v, float covered) const;

 private:
  static constexpr int kLevels = 8;  // 256 .. 2 texels a side
  void fill_levels();                // from the finest
  Texel bilinear(int level, float u, float v) const;

  std::array<std::vector<Texel>, kLevels> levels_;  // [side, side]
};

enum class Environment { Street, Hall, NightCity };

// The surroundings in every direction, as the six faces of a cube: face = 2 * axis + (negative direction).
class Panorama {
 public:
  // face_px: texels a side of a face. direction (y down) need not be normalised.
  Panorama(Environment kind, std::uint64_t seed, int face_px, WorkerPool& pool);
  Colour at(Vec3 direction) const;

 private:
  int side_;
  std::vector<Texel> texels_;  // [6, side, side]
};

}  // namespace hdrcam
