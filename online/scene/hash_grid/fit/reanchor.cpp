#include "online/scene/hash_grid/fit/reanchor.h"

#include <array>

#include "online/scene/hash_grid/field/view_geometry.h"

namespace hdrcam {
namespace {

// From points of the new anchor's window to those of the old one's.
class AnchorChange {
 public:
  AnchorChange(const WindowFrustum& frustum, const RigidTransform& T_old_new)
      : anchor_(frustum, RigidTransform()), moved_(frustum, T_old_new) {}

  // A window point of the new anchor is a pixel and an inverse depth of its camera.
  std::array<float, 3> old_position(const double at[3]) const {
    double pixel[3], x[3];
    anchor_.project(at, pixel, nullptr);
    moved_.place(pixel, anchor_.inverse_depth(at[2]), x);
    return {static_cast<float>(x[0]), static_cast<float>(x[1]), static_cast<float>(x[2])};
  }

 private:
  ViewGeometry<double> anchor_, moved_;
};

// A slot of a dense level: the table becomes what the one before says at the old positions of its vertices.
void resample(const HashLevel& level, int slot, const AnchorChange& change, std::span<const float> before,
              std::span<float> table) {
  const int vertices[3] = {static_cast<int>(level.cells[0]) + 1, static_cast<int>(level.cells[1]) + 1,
                           static_cast<int>(level.cells[2]) + 1};
  for (int k = 0; k < vertices[2]; ++k)
    for (int j = 0; j < vertices[1]; ++j)
      for (int i = 0; i < vertices[0]; ++i) {
        const double at[3] = {i / static_cast<double>(level.cells[0]),
                              j / static_cast<double>(level.cells[1]),
                              k / static_cast<double>(level.cells[2])};
        const auto corners = grid_corners(level, change.old_position(at).data(), slot);
        const std::size_t entry =
            static_cast<std::size_t>(slot) * level.entries + static_cast<std::size_t>(i) +
            static_cast<std::size_t>(j) * level.stride[1] + static_cast<std::size_t>(k) * level.stride[2];
        for (std::size_t f = 0; f < HashGrid<float>::kFeatures; ++f) {
          float value = 0;
          for (int c = 0; c < 8; ++c) value += corners.weight[c] * before[2 * corners.entry[c] + f];
          table[2 * entry + f] = value;
        }
      }
}

}  // namespace

void carry_over(HashGrid<float>& grid, const WindowFrustum& frustum, const RigidTransform& T_old_new,
                std::vector<float>& before) {
  const AnchorChange change(frustum, T_old_new);
  for (int l = 0; l < grid.shape().levels; ++l) {
    const HashLevel& level = grid.level(l);
    const std::span<float> table = grid.table(l);
    if (!level.dense) {
      std::fill(table.begin(), table.end(), 0.f);
      continue;
    }
    before.assign(table.begin(), table.end());
    for (int slot = 0; slot < grid.shape().slots; ++slot) resample(level, slot, change, before, table);
  }
}

}  // namespace hdrcam
