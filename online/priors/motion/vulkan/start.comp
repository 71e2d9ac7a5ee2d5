#version 450
#extension GL_GOOGLE_include_directive : require
// Where the search of each patch starts: the given motion, and what the coarser scale found. Where the picture
// is clipped only the latter, which comes from the surroundings: what is given could never be refuted.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int rows, cols, scale, patch_rows, patch_cols, stride;
  int given_rows, given_cols;      // full size
  int coarser_rows, coarser_cols;  // 0: this is the coarsest scale
  float brightest;
  ivec2 guided, first_given, carried;  // by direction; first_given: of the planes of `given`
  vec2 share;
};
READS(0, Level, level)
READS(1, Given, given)
READS(2, Coarser, coarser)
WRITES(3, Patches, patches)
WRITES(4, Starts, starts)
#include "online/priors/motion/vulkan/flow.glsl"
#include "online/priors/motion/vulkan/patches.glsl"

float given_at(int plane, int y, int x) { return given[(plane * given_rows + y) * given_cols + x]; }
vec2 vector_at(int plane, int y, int x) { return vec2(given_at(plane, y, x), given_at(plane + 1, y, x)); }

// Bilinear; outside, the nearest place inside.
vec2 vector_between(int plane, vec2 place) {
  const vec2 inside = clamped(place, vec2(0), vec2(given_cols - 1, given_rows - 1));
  const ivec2 near = ivec2(inside), far = min(near + 1, ivec2(given_cols - 1, given_rows - 1));
  const vec2 f = inside - vec2(near);
  const vec2 upper = mix(vector_at(plane, near.y, near.x), vector_at(plane, near.y, far.x), f.x);
  const vec2 lower = mix(vector_at(plane, far.y, near.x), vector_at(plane, far.y, far.x), f.x);
  return mix(upper, lower, f.y);
}

vec2 guess_at(int direction, int y, int x) {
  const int first = first_given[direction];
  const vec2 here = share[direction] * vector_at(first, y, x);
  if (carried[direction] == 0) return here;
  return share[direction] * vector_between(first, vec2(x, y) + here);
}

void main() {
  const int col = column(), row = row(), direction = plane(), first = kVectorPlanes * direction;
  if (col >= patch_cols) return;
  const ivec2 middle = corner_of(row, col) + kPatchSize / 2;
  vec2 here = vec2(0);
  if (guided[direction] != 0)
    here = guess_at(direction, middle.y << scale, middle.x << scale) / float(1 << scale);
  vec2 found = here;
  if (coarser_rows > 0) {
    const int y = min(middle.y / 2, coarser_rows - 1), x = min(middle.x / 2, coarser_cols - 1);
    for (int c = 0; c < 2; ++c)
      found[c] = 2 * coarser[((first + c) * coarser_rows + y) * coarser_cols + x];
  }
  const bool clipped = level[at(own_plane(direction), middle.y, middle.x)] >= brightest;
  for (int c = 0; c < 2; ++c) {
    patches[of_patch(first + c, row, col)] = found[c];
    starts[of_patch(first + c, row, col)] = clipped ? found[c] : here[c];
  }
}
