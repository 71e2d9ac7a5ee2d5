// Samples of a hash grid and the eight lattice vertices around each. Scalar type T as in hash_grid.h.
// Reentrant.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "hal/core/image.h"
#include "online/scene/hash_grid/field/field_kernels.h"

namespace hdrcam {

// Samples of one evaluation: position u, v, d as three rows of [3, 1, ld], slot [ld]; n used, a multiple of
// kSampleMultiple.
template <class T>
struct GridSamples {
  const Image<T>& position;
  const std::vector<std::int32_t>& slot;
  int n;
};

template <class T>
struct GridCorners {
  std::uint32_t entry[8];  // row of the level's table
  T weight[8];
  T fraction[3];
  bool inside[3];  // false where the coordinate was clamped to the cube
};

// The eight lattice vertices around a position; corner bit a = 1 on the far side along axis a.
template <class T>
GridCorners<T> grid_corners(const HashLevel& level, const T position[3], std::int32_t slot) {
  GridCorners<T> at;
  std::uint32_t side[3][2];
  for (int axis = 0; axis < 3; ++axis) {
    const T cells = static_cast<T>(level.cells[axis]), raw = position[axis] * cells;
    const T x = std::max(std::min(raw, cells * T(0.999999)), T(0));
    const auto vertex = static_cast<std::uint32_t>(x);
    at.fraction[axis] = x - static_cast<T>(vertex);
    at.inside[axis] = x == raw;
    side[axis][0] = vertex * level.stride[axis];
    side[axis][1] = side[axis][0] + level.stride[axis];
  }
  for (unsigned corner = 0; corner < 8; ++corner) {
    const std::uint32_t a = side[0][corner & 1], b = side[1][(corner >> 1) & 1], c = side[2][corner >> 2];
    const std::uint32_t vertex = level.dense ? a + b + c : (a ^ b ^ c) & (level.entries - 1);
    at.entry[corner] = vertex + static_cast<std::uint32_t>(slot) * level.entries;
    at.weight[corner] = 1;
    for (unsigned axis = 0; axis < 3; ++axis)
      at.weight[corner] *= (corner >> axis) & 1 ? at.fraction[axis] : 1 - at.fraction[axis];
  }
  return at;
}

}  // namespace hdrcam
