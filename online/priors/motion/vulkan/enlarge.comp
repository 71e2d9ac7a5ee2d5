#version 450
#extension GL_GOOGLE_include_directive : require
// A flow of both directions at twice its size, perhaps with an odd last row or column.
#include "hal/gpu/element.glsl"
layout(push_constant) uniform Constants {
  int rows, cols, half_rows, half_cols;
};
READS(0, Half, half_size)
WRITES(1, Whole, whole)

float at(int y, int x) {
  return half_size[(plane() * half_rows + clamp(y, 0, half_rows - 1)) * half_cols + clamp(x, 0, half_cols - 1)];
}
int beside(int i) { return i / 2 + (i % 2 == 0 ? -1 : 1); }

void main() {
  const int x = column(), y = row();
  if (x >= cols) return;
  // twice: pixels become half as large
  const float near = 1.5 * at(y / 2, x / 2) + 0.5 * at(beside(y), x / 2);
  const float far = 1.5 * at(y / 2, beside(x)) + 0.5 * at(beside(y), beside(x));
  whole[(plane() * rows + y) * cols + x] = 0.75 * near + 0.25 * far;
}
