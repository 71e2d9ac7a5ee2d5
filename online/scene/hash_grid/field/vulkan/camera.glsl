// Cameras that look into window space; the twin is ../view_geometry.h. Includers declare `focal`, `centre`,
// `size`, `margin` and `views`.
//   views  [camera][to anchor 3x4, from anchor 3x4], translations over the near plane
#include "online/scene/hash_grid/field/view_constants.h"

struct View {
  vec4 x, y, z;  // rows
};
// Kept by the caller: loads are dear.
View to_anchor(int view) {
  const int at = 6 * view;
  return View(views[at], views[at + 1], views[at + 2]);
}
View from_anchor(int view) {
  const int at = 6 * view + 3;
  return View(views[at], views[at + 1], views[at + 2]);
}

vec3 carried(View view, vec2 ray, float q) {
  const vec4 p = vec4(ray, 1, q);
  return vec3(dot(view.x, p), dot(view.y, p), max(dot(view.z, p), kNearest));
}

vec3 place(View to_anchor, vec2 pixel, float q) {
  const vec3 p = carried(to_anchor, (pixel - centre) / focal, q);
  return vec3(((focal * p.xy / p.z + centre) / size - 0.5) / margin + 0.5,
              kDepthOffset + kDepthScale * q / p.z);
}

vec3 project(View from_anchor, vec3 x) {
  const float q = (x.z - kDepthOffset) / kDepthScale;
  const vec3 p = carried(from_anchor, (((x.xy - 0.5) * margin + 0.5) * size - centre) / focal, q);
  return vec3(focal * p.xy / p.z + centre, q / p.z);
}

// A place in pixels, from the centre of the first one on, clamped to the picture. As comparisons: what is not a
// number is in the picture, too.
vec2 in_picture(vec2 free) {
  const vec2 last = size - 1, near = mix(last, free, lessThan(free, last));
  return mix(vec2(0), near, greaterThan(near, vec2(0)));
}
