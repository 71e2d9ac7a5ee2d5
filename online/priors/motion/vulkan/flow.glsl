// Both pictures of one scale [gray dx dy of a, gray dx dy of b, rows, cols], and vectors of both directions
// [u v there, u v back, ..]: direction 0 leads from a to b, direction 1 back. Includers declare `rows`, `cols`
// and `level`; those of patches also `patch_cols`, `patch_rows` and `stride`.
#include "online/priors/motion/flow_constants.h"

const int kPicturePlanes = 3, kVectorPlanes = 2;
const float kPixels = kPatchSize * kPatchSize;

int own_plane(int direction) { return kPicturePlanes * direction; }
int other_plane(int direction) { return kPicturePlanes * (1 - direction); }

// As comparisons: what is not a number is at `low`, as on the processor.
float clamped(float v, float low, float high) { return v > low ? (v < high ? v : high) : low; }
vec2 clamped(vec2 v, vec2 low, vec2 high) {
  return vec2(clamped(v.x, low.x, high.x), clamped(v.y, low.y, high.y));
}

int at(int plane, int y, int x) { return (plane * rows + y) * cols + x; }
// Of the nearest pixel of the picture.
float near(int plane, int y, int x) { return level[at(plane, clamp(y, 0, rows - 1), clamp(x, 0, cols - 1))]; }
