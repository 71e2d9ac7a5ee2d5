// Positions of N samples in a pixel and in its exposure, N a power of two: even in space, even in time, and
// centred, so that a picture neither shifts nor blurs when its pixels are sampled more densely. The positions
// are the first points of Sobol's sequence in two dimensions (a (0, 2)-sequence: any 2^m points fill every
// elementary interval once), moved by half a stratum. Their order is that of the instants: it begins in the
// middle of the sequence, which from its start goes from left to right, so that something that moves with it
// would blur twice as far and something that moves against it not at all. Immutable, reentrant.
#pragma once

#include <array>
#include <cstdint>

#include "hal/core/check.h"
#include "hal/sim/geometry.h"

namespace hdrcam {

class PixelSamples {
 public:
  static constexpr int kMost = 64;

  PixelSamples() {
    for (std::uint32_t i = 0; i < kMost; ++i) {
      std::uint32_t x = 0, y = 0, v = 1u << 31;
      for (std::uint32_t bit = 0, rest = i; rest != 0; ++bit, rest >>= 1, v ^= v >> 1)
        if ((rest & 1) != 0) x |= 1u << (31 - bit), y ^= v;
      points_[i] = {static_cast<float>(x) * 0x1p-32f, static_cast<float>(y) * 0x1p-32f};
    }
  }

  // Position in the pixel, 0..1, at the sample-th of n instants. Samples n .. 2n - 1 are n more at the same
  // instants, centred by themselves.
  Vec2 place(int sample, int n) const {
    const float half_stratum = sample < n ? 0.5f / static_cast<float>(n) : 0;
    const int instant = sample % n, in_sequence = sample - instant + (instant + n / 2) % n;
    const Vec2 point = points_[static_cast<std::size_t>(in_sequence)];
    return {point.x + half_stratum, point.y + half_stratum};
  }

 private:
  std::array<Vec2, kMost> points_;
};

}  // namespace hdrcam
