// A branch of the field and the cameras of its window as the kernels read them (corners.glsl, network.comp,
// camera.glsl). Reentrant.
#pragma once

#include <span>
#include <vector>

#include "hal/core/result.h"
#include "online/scene/hash_grid/field/field.h"

namespace hdrcam {

constexpr std::size_t kMostLevels = HashGridShape::kMostLevels, kLevelWords = 8;  // of the kernels' uniforms
constexpr std::size_t kViewFloats = 24;                                           // of a camera

// Unsupported, saying what to do, where a network is larger than the kernels' room.
Result<void> check_fits_kernels(const Mlp<float>& mlp);

// [levels][kLevelWords]: HashLevel.
std::vector<std::uint32_t> words_of(const HashGrid<float>& grid);

// A network's parameters in tiles of four outputs, layer after layer: [outputs / 4][1 + inputs][4 outputs],
// the biases first; and back.
std::vector<float> tiled(const Mlp<float>& mlp, std::span<const float> parameters);
void untile(const Mlp<float>& mlp, std::span<const float> tiles, std::span<float> parameters);

// Appends kViewFloats: to the anchor and from it, translations over the near plane.
void append_view(const WindowFrustum& frustum, const RigidTransform& T_anchor_camera,
                 std::vector<float>& views);

}  // namespace hdrcam
