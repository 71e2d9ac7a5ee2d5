#include "online/scene/hash_grid/field/vulkan/branch_layout.h"

#include <fmt/format.h>

#include <bit>

namespace hdrcam {
namespace {

// Calls f(place in the tiles, place in the parameters) for each parameter.
template <class F>
void for_each_place(const Mlp<float>& mlp, F&& f) {
  const int widths[] = {mlp.inputs(), mlp.hidden(), mlp.hidden(), mlp.outputs()};
  std::size_t first = 0, place = 0;
  for (int layer = 0; layer < Mlp<float>::kLayers; ++layer) {
    const auto in = static_cast<std::size_t>(widths[layer]),
               out = static_cast<std::size_t>(widths[layer + 1]);
    for (std::size_t o = 0; o < out; o += 4) {
      for (std::size_t k = 0; k < 4; ++k) f(place++, first + in * out + o + k);
      for (std::size_t i = 0; i < in; ++i)
        for (std::size_t k = 0; k < 4; ++k) f(place++, first + (o + k) * in + i);
    }
    first += (in + 1) * out;
  }
}

}  // namespace

Result<void> check_fits_kernels(const Mlp<float>& mlp) {
  using namespace branch_constants;
  if (mlp.parameters().size() <= kMostParameters && std::max(mlp.inputs(), mlp.hidden()) <= kMostWidth)
    return {};
  return Error{ErrorCode::Unsupported,
               fmt::format("a network of {} parameters does not fit into the kernel's {}; reduce the knob "
                           "hidden, or use --backend cpu",
                           mlp.parameters().size(), kMostParameters)};
}

std::vector<std::uint32_t> words_of(const HashGrid<float>& grid) {
  std::vector<std::uint32_t> words;
  for (int l = 0; l < grid.shape().levels; ++l) {
    const HashLevel& level = grid.level(l);
    for (const float cells : level.cells) words.push_back(std::bit_cast<std::uint32_t>(cells));
    words.push_back(level.dense ? 1 : 0);
    words.insert(words.end(), std::begin(level.stride), std::end(level.stride));
    words.push_back(level.entries);
  }
  return words;
}

std::vector<float> tiled(const Mlp<float>& mlp, std::span<const float> parameters) {
  std::vector<float> tiles(parameters.size());
  for_each_place(mlp, [&](std::size_t tile, std::size_t parameter) { tiles[tile] = parameters[parameter]; });
  return tiles;
}

void untile(const Mlp<float>& mlp, std::span<const float> tiles, std::span<float> parameters) {
  for_each_place(mlp, [&](std::size_t tile, std::size_t parameter) { parameters[parameter] = tiles[tile]; });
}

void append_view(const WindowFrustum& frustum, const RigidTransform& T_anchor_camera,
                 std::vector<float>& views) {
  for (const RigidTransform& T : {T_anchor_camera, T_anchor_camera.inverse()})
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) views.push_back(static_cast<float>(T.R(i, j)));
      views.push_back(static_cast<float>(T.t(i) / static_cast<double>(frustum.near)));
    }
}

}  // namespace hdrcam
