#version 450
#extension GL_GOOGLE_include_directive : require
// One tile of one channel: its spectrum, each coefficient scaled by how far it is above the noise, and back,
// added to the sums of its pixels. One invocation per tile. The tiles of one run do not overlap, so that sums
// need no atomics and have one order: of lines that are a tile apart every second tile, then the other half,
// then those at the end that are out of step.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int rows, cols, tile_rows, tile_cols, line_step, shift;
  float least, rise, chroma;  // of the thresholds
  int first_line, line_stride, part;  // part: 0 and 1 the halves, 2 the end
};
READS(0, Opponent, opponent)
CHANGES(1, Sums, sums)
WRITES(2, Weights, weights)
#include "render/vulkan/tiles.glsl"
#include "render/vulkan/cosines.glsl"

const vec4 kFrequencies[2] = {vec4(0, 1, 2, 3) / (kTile - 1), vec4(4, 5, 6, 7) / (kTile - 1)};

void main() {
  const int c = plane(), i = first_line + row() * line_stride;
  const int j = part < 2 ? 2 * column() + part : tiles_in_line(i) - 1 + column();
  if (j >= tiles_in_line(i) || in_step(i, j) != (part < 2)) return;
  const int corner = at(c, line_of(i), column_of(i, j)), noise_corner = corner + 3 * rows * cols;

  vec4 tile[16], noises = vec4(0);
  [[unroll]] for (int k = 0; k < 16; ++k) {
    const int from = k / 2 * cols + k % 2 * 4;
    for (int n = 0; n < 4; ++n) tile[k][n] = opponent[corner + from + n];
    for (int n = 0; n < 4; ++n) noises[n] += opponent[noise_corner + from + n];
  }
  const float noise = dot(noises, vec4(1)) / (kTile * kTile);

  forward_columns(tile);
  forward_rows(tile);
  const float mean = tile[0].x;  // is kept whole
  const float doubt = noise * least * (c == 0 ? 1 : chroma);
  vec4 energies = vec4(0);  // of the gains
  [[unroll]] for (int k = 0; k < 16; ++k) {
    const vec4 power = tile[k] * tile[k];
    const vec4 threshold = doubt * (1 + rise * float(k / 2) / (kTile - 1)) * (1 + rise * kFrequencies[k % 2]);
    vec4 gain = max(vec4(0), (power - threshold) / (power + kLeastPower));
    if (k == 0) gain.x = 0;
    tile[k] *= gain;
    energies += gain * gain;
  }
  tile[0].x = mean;
  const float weight = 1 / ((1 + dot(energies, vec4(1))) * (noise + kLeastNoise));
  backward_rows(tile);
  backward_columns(tile);

  weights[tile_at(c, i, j)] = weight;
  [[unroll]] for (int k = 0; k < 16; ++k) {
    const int to = corner + k / 2 * cols + k % 2 * 4;
    for (int n = 0; n < 4; ++n) sums[to + n] += weight * tile[k][n];
  }
}
