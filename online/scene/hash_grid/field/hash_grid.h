// Multiresolution hash grid (Müller et al. 2022) over the window's unit cube (u, v, inverse depth), two
// features per level. A grid may have several tables per level, its slots: the dynamic branch has one slot
// per frame of the window, which makes (u, v, d, t) a four-dimensional grid that is exact in t, costs 8
// look-ups instead of 16, and lets a new frame start from the previous one by copying its slot. Scalar type
// T: float in the product (field_kernels.h), double in the gradient tests (plain_kernels.h).
// Thread-compatible; distinct levels may be scattered into by distinct threads.
#pragma once

#include <algorithm>
#include <span>
#include <type_traits>
#include <vector>

#include "hal/core/image.h"
#include "online/scene/hash_grid/field/plain_kernels.h"
#include "online/scene/hash_grid/field/random.h"

namespace hdrcam {

struct HashGridShape {
  static constexpr int kMostLevels = 16;  // as many as the shaders' uniform block has room for (corners.glsl)
  static constexpr int kFewestLog2Entries = 6, kMostLog2Entries = 20;

  int levels = 8;           // 1..kMostLevels; an even number below a network (mlp.h)
  int log2_entries = 15;    // table entries per level and slot, kFewest..kMostLog2Entries
  int slots = 1;            // tables per level
  int coarsest_cells = 16;  // along u at the first level
  int finest_cells = 320;   // along u at the last level; geometric in between
  float v_ratio = 0.75f;    // cells along v per cell along u
  // Cells along inverse depth per cell along u: depth varies more slowly than the picture.
  float d_ratio = 0.25f;

  bool operator==(const HashGridShape&) const = default;
};

std::vector<HashLevel> hash_levels(const HashGridShape& shape);

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
