// The eight lattice vertices around a position (../grid_corners.h). Includers declare `levels`.
//   levels  [level][cells along u, v, d, and dense or not; strides along u, v, d, and entries]: HashLevel
struct Corners {
  uvec3 low, high;               // vertex times stride, on the near and the far side
  vec3 fraction, inside, cells;  // inside: 0 where the coordinate was clamped to the cube
  uint entries;
  bool dense;
};

Corners corners_at(int level, vec3 position) {
  const uvec4 lattice = levels[2 * level], strides = levels[2 * level + 1];
  Corners at;
  at.cells = uintBitsToFloat(lattice.xyz);
  const vec3 raw = position * at.cells, last = at.cells * 0.999999;
  // as comparisons: what is not a number is in the cube, too
  const vec3 near = mix(last, raw, lessThan(raw, last)), x = mix(vec3(0), near, greaterThan(near, vec3(0)));
  const uvec3 vertex = uvec3(x);
  at.fraction = x - vec3(vertex);
  at.inside = vec3(equal(x, raw));
  at.low = vertex * strides.xyz, at.high = at.low + strides.xyz;
  at.entries = strides.w, at.dense = lattice.w != 0;
  return at;
}

// The far side along u, v, d of corner 0..7.
bvec3 is_far(int corner) { return bvec3((corner & 1) != 0, (corner & 2) != 0, (corner & 4) != 0); }

// Row of the level's table.
uint entry_of(Corners at, int corner, uint slot) {
  const bvec3 far = is_far(corner);
  const uint a = far.x ? at.high.x : at.low.x, b = far.y ? at.high.y : at.low.y;
  const uint c = far.z ? at.high.z : at.low.z;
  return (at.dense ? a + b + c : (a ^ b ^ c) & (at.entries - 1)) + slot * at.entries;
}

float weight_of(Corners at, int corner) {
  const vec3 w = mix(1 - at.fraction, at.fraction, is_far(corner));
  return w.x * w.y * w.z;
}
