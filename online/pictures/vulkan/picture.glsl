// Planar pictures [planes, rows, cols] and positions in them; the twins are online/pictures/warp.cpp and
// local_statistics.cpp. Includers declare `rows` and `cols`.
int at(int channel, int y, int x) { return (channel * rows + y) * cols + x; }
bool is_pixel() { return column() < cols; }

int mirrored(int i, int n) {
  if (n == 1) return 0;
  if (i < 0) i = -i;
  if (i >= n) i = 2 * n - 2 - i;
  return clamp(i, 0, n - 1);
}

float smooth_step(float begin, float end, float x) {
  const float t = clamp((x - begin) / (end - begin), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

#include "hal/core/subpixels.h"

// A position split into whole pixels (xy) and subpixels (zw). Far outside or not a number: the border.
ivec4 split_position(float px, float py) {
  px = px > -kOutside ? min(px, float(cols + kOutside)) : -kOutside;
  py = py > -kOutside ? min(py, float(rows + kOutside)) : -kOutside;
  const int qx = int(floor(px * kSubpixels + 0.5)), qy = int(floor(py * kSubpixels + 0.5));
  return ivec4(qx >> kShift, qy >> kShift, qx & (kSubpixels - 1), qy & (kSubpixels - 1));
}

// Catmull-Rom weights of the four pixels around a place `fraction` of the way from the second to the third.
vec4 cubic_weights(float fraction) {
  const float a = -0.5, f = fraction, g = 1 - fraction;
  vec4 w;
  w.x = ((a * (f + 1) - 5 * a) * (f + 1) + 8 * a) * (f + 1) - 4 * a;
  w.y = ((a + 2) * f - (a + 3)) * f * f + 1;
  w.z = ((a + 2) * g - (a + 3)) * g * g + 1;
  w.w = 1 - w.x - w.y - w.z;
  return w;
}
