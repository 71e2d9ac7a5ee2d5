#version 450
#extension GL_GOOGLE_include_directive : require
// A picture moved along a motion [dx, dy, ..]: the first `cubic_planes` planes by cubic convolution, within `limit` of the
// bilinear value, the others bilinearly. Where `dark` is above 0, the cubic planes are log_radiance.comp's of `radiance` and
// become radiance again; what does not move is copied.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int rows, cols, cubic_planes;
  float limit, dark;
};
READS(0, Source, source)
READS(1, Motion, motion)
WRITES(2, Moved, moved)
READS(3, Radiance, radiance)
#include "online/pictures/vulkan/picture.glsl"
#include "online/pictures/vulkan/interpolate.glsl"

void main() {
  if (!is_pixel()) return;
  const int x = column(), y = row(), c = plane();
  const ivec4 place = split_position(float(x) + motion[at(0, y, x)], float(y) + motion[at(1, y, x)]);
  const int here = at(c, y, x);
  if (c >= cubic_planes)
    moved[here] = linear_at(c, place);
  else if (dark == 0)
    moved[here] = cubic_at(c, place, limit);
  else
    moved[here] = place == ivec4(x, y, 0, 0) ? radiance[here] : max(0, exp(cubic_at(c, place, limit)) - dark);
}
