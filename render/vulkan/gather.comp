#version 450
#extension GL_GOOGLE_include_directive : require
// Each pixel as the mean of the tiles that cover it, by their weights, back in radiance.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int rows, cols, tile_rows, tile_cols, line_step, shift;
  float offset;
};
READS(0, Sums, sums)
READS(1, Weights, weights)
WRITES(2, Radiance, radiance)
#include "render/vulkan/tiles.glsl"

void main() {
  const int x = column(), y = row();
  if (x >= cols) return;
  const int i0 = max(0, (y - kTile + line_step) / line_step), i1 = min(y / line_step + 1, tile_rows - 1);
  vec3 total = vec3(0);  // of the weights of the tiles that cover this pixel
  for (int i = i0; i <= i1; ++i) {
    const int v = y - line_of(i), along = x - shift_of(i);
    if (v < 0 || v >= kTile) continue;
    const int j0 = max(0, (along - kTile + kStep) / kStep), j1 = min(along / kStep + 1, tiles_in_line(i) - 1);
    for (int j = j0; j <= j1; ++j) {
      const int u = x - column_of(i, j);
      if (u < 0 || u >= kTile) continue;
      for (int c = 0; c < 3; ++c) total[c] += weights[tile_at(c, i, j)];
    }
  }
  vec3 mean;
  for (int c = 0; c < 3; ++c) mean[c] = sums[at(c, y, x)] / total[c];
  for (int k = 0; k < 3; ++k) {
    float log_radiance = 0;
    for (int c = 0; c < 3; ++c) log_radiance += kOpponent[c][k] * mean[c];
    radiance[at(k, y, x)] = max(0.0, exp(log_radiance) - offset);
  }
}
