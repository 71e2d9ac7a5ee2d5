#include "online/scene/hash_grid/fit/reanchor.h"

#include "online/scene/hash_grid/field/view_geometry.h"

namespace hdrcam {

void carry_over(HashGrid<float>& grid, const WindowFrustum& frustum, const RigidTransform& T_old_new,
                std::vector<float>& before) {
  const ViewGeometry<double> old_anchor(frustum, RigidTransform()), moved(frustum, T_old_new);
  for (int l = 0; l < grid.shape().levels; ++l) {
    const HashLevel& level = grid.level(l);
    const std::span<float> table = grid.table(l);
    if (!level.dense) {
      std::fill(table.begin(), table.end(), 0.f);
      continue;
    }
    before.assign(table.begin(), table.end());
    const int vertices[3] = {static_cast<int>(level.cells[0]) + 1, static_cast<int>(level.cells[1]) + 1,
                             static_cast<int>(level.cells[2]) + 1};
    for (int slot = 0; slot < grid.shape().slots; ++slot)
      for (int k = 0; k < vertices[2]; ++k)
        for (int j = 0; j < vertices[1]; ++j)
          for (int i = 0; i < vertices[0]; ++i) {
            const double at[3] = {i / static_cast<double>(level.cells[0]),
                                  j / static_cast<double>(level.cells[1]),
                                  k / static_cast<double>(level.cells[2])};
            // a window point of the new anchor is a pixel and an inverse depth of its camera
            double pixel[3], x[3];
            old_anchor.project(at, pixel, nullptr);
            moved.place(pixel, old_anchor.inverse_depth(at[2]), x);
            const float position[3] = {static_cast<float>(x[0]), static_cast<float>(x[1]),
                                       static_cast<float>(x[2])};
            const auto corners = grid_corners(level, position, slot);
            const std::size_t entry =
                static_cast<std::size_t>(slot) * level.entries + static_cast<std::size_t>(i) +
                static_cast<std::size_t>(j) * level.stride[1] + static_cast<std::size_t>(k) * level.stride[2];
            for (std::size_t f = 0; f < 2; ++f) {
              float value = 0;
              for (int c = 0; c < 8; ++c) value += corners.weight[c] * before[2 * corners.entry[c] + f];
              table[2 * entry + f] = value;
            }
          }
  }
}

}  // namespace hdrcam
