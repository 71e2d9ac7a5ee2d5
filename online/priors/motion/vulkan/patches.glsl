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
  const vec2 place = min(max(vec2(corner) + by, vec2(-kOutside)), outermost);
  const vec2 whole = floor(place);
  return Window(ivec2(whole), place - whole);
}
