// Multiresolution hash grid (Müller et al. 2022) over the window's unit cube (u, v, inverse depth), two
// features per level. A grid may have several tables per level, its slots: the dynamic branch has one slot
// per frame of the window, which makes (u, v, d, t) a four-dimensional grid that is exact in t, costs 8
// look-ups instead of 16, and lets a new frame start from the previous one by copying its slot. Scalar type
// T: float in the product (kernels), double in the gradient tests (the loops below). Thread-compatible;
// distinct levels may be scattered into by distinct threads.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <type_traits>
#include <vector>

#include "hal/core/image.h"
#include "online/scene/hash_grid/field/field_kernels.h"
#include "online/scene/hash_grid/field/random.h"

namespace hdrcam {

struct HashGridShape {
  int levels = 8;           // 1..16
  int log2_entries = 15;    // table entries per level and slot, 10..20
  int slots = 1;            // tables per level
  int coarsest_cells = 16;  // along u at the first level
  int finest_cells = 320;   // along u at the last level; geometric in between
  float v_ratio = 0.75f;    // cells along v per cell along u
  float d_ratio =
      0.25f;  // cells along inverse depth per cell along u: depth varies more slowly than the picture

  bool operator==(const HashGridShape&) const = default;
};

std::vector<HashLevel> hash_levels(const HashGridShape& shape);

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

template <class T>
class HashGrid {
 public:
  static constexpr int kFeatures = 2;

  HashGrid(const HashGridShape& shape, float spread, Pcg32& random)
      : shape_(shape), levels_(hash_levels(shape)) {
    level_size_ = static_cast<std::size_t>(shape.slots) * levels_[0].entries * kFeatures;
    table_.reshape(shape.levels, 1, static_cast<int>(level_size_));
    for (T& value : table_.samples()) value = static_cast<T>(random.uniform(-spread, spread));
  }
  // Room for d_table(), which only a fit needs.
  void reserve_gradient() { d_table_ = Image<T>(shape_.levels, 1, static_cast<int>(level_size_)); }

  const HashGridShape& shape() const { return shape_; }
  int features() const { return shape_.levels * kFeatures; }
  const HashLevel& level(int l) const { return levels_[static_cast<std::size_t>(l)]; }
  std::span<T> table(int l) { return {table_.plane(l), level_size_}; }
  std::span<T> d_table(int l) { return {d_table_.plane(l), level_size_}; }
  Image<T>& tables() { return table_; }
  const Image<T>& tables() const { return table_; }

  // features [2 * levels, 1, ld] <- table
  void encode(const GridSamples<T>& at, Image<T>& features) const {
    for (int l = 0; l < shape_.levels; ++l)
      encode_level(l, at, features.plane(2 * l), features.plane(2 * l + 1));
  }
  // gradient of table l += d_features; samples in order
  void scatter(int l, const GridSamples<T>& at, const Image<T>& d_features);
  // d_position [3, 1, ld] += gradient with respect to the position
  void position_backward(const GridSamples<T>& at, const Image<T>& d_features, Image<T>& d_position) const {
    for (int l = 0; l < shape_.levels; ++l)
      position_backward_level(l, at, d_features.plane(2 * l), d_features.plane(2 * l + 1), d_position);
  }
  // slot `to` becomes a copy of slot `from` on every level
  void copy_slot(int from, int to, Image<T>& values) const {
    const std::size_t size = levels_[0].entries * kFeatures;
    for (int l = 0; l < shape_.levels; ++l)
      std::copy_n(values.plane(l) + static_cast<std::size_t>(from) * size, size,
                  values.plane(l) + static_cast<std::size_t>(to) * size);
  }

 private:
  static constexpr bool kFast = std::is_same_v<T, float>;
  static GridQuery query(const GridSamples<T>& at) {
    return {{at.position.plane(0), at.position.plane(1), at.position.plane(2)}, at.slot.data(), at.n};
  }
  void encode_level(int l, const GridSamples<T>& at, T* feature0, T* feature1) const;
  void position_backward_level(int l, const GridSamples<T>& at, const T* d_feature0, const T* d_feature1,
                               Image<T>& d_position) const;

  HashGridShape shape_;
  std::vector<HashLevel> levels_;
  std::size_t level_size_ = 0;
  Image<T> table_, d_table_;  // [levels, 1, slots * entries * 2]
};

// The scalar twins of the kernels.
namespace plain {

template <class T>
void encode(const HashLevel& level, const T* table, const GridSamples<T>& at, T* feature0, T* feature1) {
  for (int s = 0; s < at.n; ++s) {
    const T position[3] = {at.position.plane(0)[s], at.position.plane(1)[s], at.position.plane(2)[s]};
    const auto corners = grid_corners(level, position, at.slot[static_cast<std::size_t>(s)]);
    feature0[s] = feature1[s] = 0;
    for (int c = 0; c < 8; ++c) {
      feature0[s] += corners.weight[c] * table[2 * corners.entry[c]];
      feature1[s] += corners.weight[c] * table[2 * corners.entry[c] + 1];
    }
  }
}

template <class T>
void scatter(const HashLevel& level, T* d_table, const GridSamples<T>& at, const T* d_feature0,
             const T* d_feature1) {
  for (int s = 0; s < at.n; ++s) {
    const T position[3] = {at.position.plane(0)[s], at.position.plane(1)[s], at.position.plane(2)[s]};
    const auto corners = grid_corners(level, position, at.slot[static_cast<std::size_t>(s)]);
    for (int c = 0; c < 8; ++c) {
      d_table[2 * corners.entry[c]] += corners.weight[c] * d_feature0[s];
      d_table[2 * corners.entry[c] + 1] += corners.weight[c] * d_feature1[s];
    }
  }
}

template <class T>
void position_backward(const HashLevel& level, const T* table, const GridSamples<T>& at, const T* d_feature0,
                       const T* d_feature1, Image<T>& d_position) {
  for (int s = 0; s < at.n; ++s) {
    const T position[3] = {at.position.plane(0)[s], at.position.plane(1)[s], at.position.plane(2)[s]};
    const auto corners = grid_corners(level, position, at.slot[static_cast<std::size_t>(s)]);
    for (unsigned axis = 0; axis < 3; ++axis) {
      if (!corners.inside[axis]) continue;
      T slope = 0;
      for (unsigned c = 0; c < 8; ++c) {
        T weight = (c >> axis) & 1 ? T(1) : T(-1);
        for (unsigned other = 0; other < 3; ++other)
          if (other != axis)
            weight *= (c >> other) & 1 ? corners.fraction[other] : 1 - corners.fraction[other];
        slope += weight * (d_feature0[s] * table[2 * corners.entry[c]] +
                           d_feature1[s] * table[2 * corners.entry[c] + 1]);
      }
      d_position.plane(static_cast<int>(axis))[s] += slope * static_cast<T>(level.cells[axis]);
    }
  }
}

}  // namespace plain

template <class T>
void HashGrid<T>::encode_level(int l, const GridSamples<T>& at, T* feature0, T* feature1) const {
  if constexpr (kFast)
    field_kernels().encode(level(l), table_.plane(l), query(at), feature0, feature1);
  else
    plain::encode(level(l), table_.plane(l), at, feature0, feature1);
}

template <class T>
void HashGrid<T>::scatter(int l, const GridSamples<T>& at, const Image<T>& d_features) {
  const T *d0 = d_features.plane(2 * l), *d1 = d_features.plane(2 * l + 1);
  if constexpr (kFast)
    field_kernels().scatter(level(l), d_table_.plane(l), query(at), d0, d1);
  else
    plain::scatter(level(l), d_table_.plane(l), at, d0, d1);
}

template <class T>
void HashGrid<T>::position_backward_level(int l, const GridSamples<T>& at, const T* d0, const T* d1,
                                          Image<T>& d_position) const {
  if constexpr (kFast) {
    float* const rows[3] = {d_position.plane(0), d_position.plane(1), d_position.plane(2)};
    field_kernels().position_backward(level(l), table_.plane(l), query(at), d0, d1, rows);
  } else {
    plain::position_backward(level(l), table_.plane(l), at, d0, d1, d_position);
  }
}

}  // namespace hdrcam
