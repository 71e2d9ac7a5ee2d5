#include "online/scene/hash_grid/field/hash_grid.h"

namespace hdrcam {

std::vector<HashLevel> hash_levels(const HashGridShape& shape) {
  HDRCAM_CHECK(shape.levels >= 1 && shape.levels <= HashGridShape::kMostLevels);
  HDRCAM_CHECK(shape.log2_entries >= HashGridShape::kFewestLog2Entries &&
               shape.log2_entries <= HashGridShape::kMostLog2Entries);
  HDRCAM_CHECK(shape.slots >= 1 && shape.coarsest_cells >= 2 && shape.finest_cells >= shape.coarsest_cells);
  const std::uint32_t entries = 1u << shape.log2_entries;
  const double growth = static_cast<double>(shape.finest_cells) / shape.coarsest_cells;
  std::vector<HashLevel> levels;
  for (int l = 0; l < shape.levels; ++l) {
    const double part = shape.levels > 1 ? static_cast<double>(l) / (shape.levels - 1) : 0;
    const double along_u = std::floor(shape.coarsest_cells * std::pow(growth, part) + 1e-6);
    const double cells[3] = {along_u, std::max(2.0, std::floor(along_u * shape.v_ratio)),
                             std::max(2.0, std::floor(along_u * shape.d_ratio))};
    const double vertices = (cells[0] + 1) * (cells[1] + 1) * (cells[2] + 1);
    HashLevel level{};
    level.entries = entries;
    level.dense = vertices <= entries;
    for (int axis = 0; axis < 3; ++axis) level.cells[axis] = static_cast<float>(cells[axis]);
    // primes of the original implementation; the first is 1 so that neighbours along u share cache lines
    level.stride[0] = 1;
    level.stride[1] = level.dense ? static_cast<std::uint32_t>(cells[0]) + 1 : 2654435761u;
    level.stride[2] = level.dense ? level.stride[1] * (static_cast<std::uint32_t>(cells[1]) + 1) : 805459861u;
    levels.push_back(level);
  }
  return levels;
}

}  // namespace hdrcam
