#version 450
#extension GL_GOOGLE_include_directive : require
// One tile of one channel: its spectrum, each coefficient scaled by how far it is above the noise, and back.
// One invocation per tile.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int rows, cols, tile_rows, tile_cols, line_step, shift;
  float least, rise, chroma;  // of the thresholds
};
READS(0, Opponent, opponent)
WRITES(1, Tiles, tiles)
#include "render/vulkan/tiles.glsl"

// Cosines [frequency][pixel], orthonormal: sqrt(1/8), then 1/2 cos((2 pixel + 1) frequency pi / 16).
const float basis[64] = {
    0.353553391, 0.353553391, 0.353553391, 0.353553391, 0.353553391, 0.353553391, 0.353553391, 0.353553391,
    0.49039264, 0.415734806, 0.277785117, 0.097545161, -0.097545161, -0.277785117, -0.415734806, -0.49039264,
    0.461939766, 0.191341716, -0.191341716, -0.461939766, -0.461939766, -0.191341716, 0.191341716, 0.461939766,
    0.415734806, -0.097545161, -0.49039264, -0.277785117, 0.277785117, 0.49039264, 0.097545161, -0.415734806,
    0.353553391, -0.353553391, -0.353553391, 0.353553391, 0.353553391, -0.353553391, -0.353553391, 0.353553391,
    0.277785117, -0.49039264, 0.097545161, 0.415734806, -0.415734806, -0.097545161, 0.49039264, -0.277785117,
    0.191341716, -0.461939766, 0.461939766, -0.191341716, -0.191341716, 0.461939766, -0.461939766, 0.191341716,
    0.097545161, -0.277785117, 0.415734806, -0.49039264, 0.49039264, -0.415734806, 0.277785117, -0.097545161};

float threshold(int channel, int i, int j) {
  return (channel == 0 ? least : chroma * least) * (1 + rise * i / (kTile - 1)) * (1 + rise * j / (kTile - 1));
}

void main() {
  if (column() >= tiles_in_line(row())) return;
  const int c = plane(), y0 = line_of(row()), x0 = column_of(row(), column());
  float a[64], b[64];
  float noise = 0;
  for (int i = 0; i < 64; ++i) {
    a[i] = opponent[at(c, y0 + i / kTile, x0 + i % kTile)];
    noise += opponent[at(3 + c, y0 + i / kTile, x0 + i % kTile)];
  }
  noise /= 64;
  for (int i = 0; i < 64; ++i) {  // b = basis a
    float sum = 0;
    for (int k = 0; k < kTile; ++k) sum += basis[i / kTile * kTile + k] * a[k * kTile + i % kTile];
    b[i] = sum;
  }
  float energy = 1;  // of the gains; the mean is kept whole
  for (int i = 0; i < 64; ++i) {  // a = b basis^T: the spectrum, shrunk
    float sum = 0;
    for (int k = 0; k < kTile; ++k) sum += b[i / kTile * kTile + k] * basis[i % kTile * kTile + k];
    if (i > 0) {
      const float power = sum * sum, gain = max(0.0, (power - threshold(c, i / kTile, i % kTile) * noise) / (power + kLeastPower));
      sum *= gain;
      energy += gain * gain;
    }
    a[i] = sum;
  }
  for (int i = 0; i < 64; ++i) {  // b = basis^T a
    float sum = 0;
    for (int k = 0; k < kTile; ++k) sum += basis[k * kTile + i / kTile] * a[k * kTile + i % kTile];
    b[i] = sum;
  }
  const float weight = 1 / (energy * (noise + kLeastNoise));
  const int to = tile_at(c, row(), column());
  tiles[to] = weight;
  for (int i = 0; i < 64; ++i) {  // b basis
    float sum = 0;
    for (int k = 0; k < kTile; ++k) sum += b[i / kTile * kTile + k] * basis[k * kTile + i % kTile];
    tiles[to + 1 + i] = weight * sum;
  }
}
