#version 450
#extension GL_GOOGLE_include_directive : require
// The dense flow: at each pixel the mean of the patches over it, by how well each explains it.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int rows, cols, patch_rows, patch_cols, stride;
};
READS(0, Level, level)
READS(1, Patches, patches)
WRITES(2, Flow, flow)
#include "online/priors/motion/vulkan/flow.glsl"
#include "online/priors/motion/vulkan/patches.glsl"

// The first and the last patch that may cover a pixel. The last one of all stands off the grid, flush with the
// edge.
int first_over(int pixel) { return max(0, (pixel - kPatchSize + stride) / stride); }
int last_over(int pixel, int count) { return min(pixel / stride + 1, count - 1); }
bool covers(int corner, int pixel) { return corner <= pixel && pixel < corner + kPatchSize; }

void main() {
  const int x = column(), y = row(), direction = plane();
  if (x >= cols) return;
  const int other = other_plane(direction), u = kVectorPlanes * direction;
  const float code = level[at(own_plane(direction), y, x)];
  vec2 sum = vec2(0);
  float weight = 0;
  for (int row = first_over(y); row <= last_over(y, patch_rows); ++row)
    for (int col = first_over(x); col <= last_over(x, patch_cols); ++col) {
      const ivec2 corner = corner_of(row, col);
      if (!covers(corner.y, y) || !covers(corner.x, x)) continue;
      const vec2 by = vec2(patches[of_patch(u, row, col)], patches[of_patch(u + 1, row, col)]);
      const Window to = window(corner, by);
      const ivec2 p = to.at + ivec2(x, y) - corner;
      const float w = 1 / max(abs(between_pixels(other, p, to.between) - code), 1);
      sum += w * by, weight += w;
    }
  flow[at(u, y, x)] = sum.x / weight, flow[at(u + 1, y, x)] = sum.y / weight;
}
