// What a hash grid has learned when the window's anchor moves: its positions are window points, whose meaning
// changes with the anchor. Reentrant for distinct grids and scratch memory.
#pragma once

#include "online/scene/hash_grid/field/hash_grid.h"
#include "online/scene/hash_grid/field/window.h"

namespace hdrcam {

// Carries a grid of the old anchor's window over into the new one's, level by level: a dense level is
// resampled at the old position of each of its vertices; hashed levels, whose vertices cannot be enumerated,
// start at zero. T_old_new: from the new anchor to the old one. before: scratch memory for the table of one
// level; allocates nothing where its capacity is that large.
void carry_over(HashGrid<float>& grid, const WindowFrustum& frustum, const RigidTransform& T_old_new,
                std::vector<float>& before);

}  // namespace hdrcam
