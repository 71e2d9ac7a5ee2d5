// Patches of a scale, after flow.glsl.
int of_patch(int plane, int row, int col) { return (plane * patch_rows + row) * patch_cols + col; }
ivec2 corner_of(int row, int col) {
  return ivec2(min(col * stride, cols - kPatchSize), min(row * stride, rows - kPatchSize));
}

// A patch moved: the first of its pixels (xy whole, zw between pixels).
struct Window {
  ivec2 at;
  vec2 between;
};
Window window(ivec2 corner, vec2 by) {
  const vec2 outermost = vec2(cols - kPatchSize + kOutside - 1, rows - kPatchSize + kOutside - 1);
  const vec2 place = clamped(vec2(corner) + by, vec2(-kOutside), outermost);
  const vec2 whole = floor(place);
  return Window(ivec2(whole), place - whole);
}

// A picture between its pixels; its edges go on.
float between_pixels(int plane, ivec2 p, vec2 f) {
  const float above = mix(near(plane, p.y, p.x), near(plane, p.y, p.x + 1), f.x);
  const float below = mix(near(plane, p.y + 1, p.x), near(plane, p.y + 1, p.x + 1), f.x);
  return mix(above, below, f.y);
}
