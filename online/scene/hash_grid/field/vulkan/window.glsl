// Window space, cameras that look into it, and the base of a frame; the twins are ../view_geometry.h and
// fetch_base() in ../window.h. Includers declare `focal`, `centre`, `size`, `margin`, `views` and `base`.
//   views  [camera, frame, next, previous][to anchor 3x4, from anchor 3x4], translations over the near plane
const int kCamera = 0, kFrame = 1, kNeighbour = 2;
const int kGate = 3, kFlow = 6, kSurface = 12, kBaseChannels = 16;
const float kNearest = 0.05, kDepthOffset = 0.01, kDepthScale = 0.98;

vec3 carried(int first, vec2 ray, float q) {
  vec3 p;
  for (int i = 0; i < 3; ++i) {
    const int line = first + 4 * i;
    p[i] = views[line] * ray.x + views[line + 1] * ray.y + views[line + 2] + views[line + 3] * q;
  }
  p.z = max(p.z, kNearest);
  return p;
}

vec3 place(int view, vec2 pixel, float q) {
  const vec3 p = carried(24 * view, (pixel - centre) / focal, q);
  return vec3(((focal * p.xy / p.z + centre) / size - 0.5) / margin + 0.5, kDepthOffset + kDepthScale * q / p.z);
}

vec3 project(int view, vec3 x) {
  const float q = (x.z - kDepthOffset) / kDepthScale;
  const vec3 p = carried(24 * view + 12, (((x.xy - 0.5) * margin + 0.5) * size - centre) / focal, q);
  return vec3(focal * p.xy / p.z + centre, q / p.z);
}

// The base where the frame sees a window point; outside its picture nothing is known of the radiance.
// Channels from kGate on; returns the prior of log density there.
float base_at(vec3 point, out float found[kBaseChannels]) {
  const vec3 seen = project(kFrame, point);
  const vec2 last = size - 1, at = clamp(seen.xy - 0.5, vec2(0), last);
  const int cols = int(size.x), rows = int(size.y);
  const int i = min(int(at.x), max(cols - 2, 0)), j = min(int(at.y), max(rows - 2, 0));
  const float fx = at.x - float(i), fy = at.y - float(j);
  const int a = (j * cols + i) * kBaseChannels, b = a + (cols > 1 ? kBaseChannels : 0);
  const int below = rows > 1 ? cols * kBaseChannels : 0;
  const float wa = (1 - fx) * (1 - fy), wb = fx * (1 - fy), wc = (1 - fx) * fy, wd = fx * fy;
  for (int k = 0; k <= kSurface; ++k)
    found[k] = wa * base[a + k] + wb * base[b + k] + wc * base[a + below + k] + wd * base[b + below + k];
  if (seen.x < -0.5 || seen.y < -0.5 || seen.x > size.x + 0.5 || seen.y > size.y + 0.5)
    for (int c = 0; c < 3; ++c) found[kGate + c] = 1;
  // surface_prior() of ../field_sample.h
  const float width = 0.01 + 0.04 * found[kSurface], away = (seen.z - found[kSurface]) / width;
  return -6 + 8 * exp(-0.5 * away * away);
}
