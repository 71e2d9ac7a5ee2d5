#version 450
#extension GL_GOOGLE_include_directive : require
// Each pixel as the mean of the tiles that cover it, by their weights, back in radiance.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int rows, cols, tile_rows, tile_cols;
  float offset;
};
READS(0, Tiles, tiles)
WRITES(1, Radiance, radiance)
#include "render/vulkan/tiles.glsl"

void main() {
  const int x = column(), y = row();
  if (x >= cols) return;
  const int i0 = max(0, (y - kTile + kStep) / kStep), i1 = min(y / kStep + 1, tile_rows - 1);
  const int j0 = max(0, (x - kTile + kStep) / kStep), j1 = min(x / kStep + 1, tile_cols - 1);
  vec3 mean;
  for (int c = 0; c < 3; ++c) {
    float sum = 0, total = 0;
    for (int i = i0; i <= i1; ++i) {
      const int v = y - first_of(i, rows);
      if (v < 0 || v >= kTile) continue;
      for (int j = j0; j <= j1; ++j) {
        const int u = x - first_of(j, cols), from = tile_at(c, i, j);
        if (u < 0 || u >= kTile) continue;
        total += tiles[from];
        sum += tiles[from + 1 + v * kTile + u];
      }
    }
    mean[c] = sum / total;
  }
  for (int k = 0; k < 3; ++k) {
    float log_radiance = 0;
    for (int c = 0; c < 3; ++c) log_radiance += kOpponent[c][k] * mean[c];
    radiance[at(k, y, x)] = max(0.0, exp(log_radiance) - offset);
  }
}
