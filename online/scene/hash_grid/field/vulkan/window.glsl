// Window space, cameras that look into it, and the base of a frame; the twins are ../view_geometry.h and
// fetch_base() in ../window.h. Includers declare what camera.glsl asks for, and `base`.
//   views  [camera, frame, next, previous], as camera.glsl has them
//   base   [rows, cols, 4 vectors]: BasePixel
#include "online/scene/hash_grid/field/ray_constants.h"
#include "online/scene/hash_grid/field/vulkan/camera.glsl"
const int kCamera = 0, kFrame = 1, kNeighbour = 2;

// What the base says of one place (../window.h).
struct Base {
  vec3 log_radiance, gate;
  vec4 flow;  // forward, backward
  float log_density;  // its prior
};

// The base where the frame sees a window point; outside its picture nothing is known of the radiance.
Base base_at(View frame, vec3 point) {
  const vec3 seen = project(frame, point);
  const vec2 at = in_picture(seen.xy - 0.5);
  const int cols = int(size.x), rows = int(size.y);
  const int i = min(int(at.x), max(cols - 2, 0)), j = min(int(at.y), max(rows - 2, 0));
  const float fx = at.x - float(i), fy = at.y - float(j);
  const int a = 4 * (j * cols + i), b = a + (cols > 1 ? 4 : 0), below = rows > 1 ? 4 * cols : 0;
  const float wa = (1 - fx) * (1 - fy), wb = fx * (1 - fy), wc = (1 - fx) * fy, wd = fx * fy;
  vec4 found[4];
  for (int k = 0; k < 4; ++k)
    found[k] = wa * base[a + k] + wb * base[b + k] + wc * base[a + below + k] + wd * base[b + below + k];
  Base result;
  result.log_radiance = found[0].xyz;
  result.gate = vec3(found[0].w, found[1].xy);
  result.flow = vec4(found[1].zw, found[2].xy);
  if (seen.x < -0.5 || seen.y < -0.5 || seen.x > size.x + 0.5 || seen.y > size.y + 0.5) result.gate = vec3(1);
  // surface_prior() of ../field_sample.h
  const float surface = found[3].x, width = kThickness + kThicknessPerDepth * surface, away = (seen.z - surface) / width;
  result.log_density = kEmptySpace + kSurface * exp(-0.5 * away * away);
  return result;
}
