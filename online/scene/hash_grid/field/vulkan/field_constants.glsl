// What every kernel of the probe is told: FieldConstants of field_probe_passes.h.
layout(push_constant) uniform Constants {
  vec2 focal, centre, size;
  float margin, offset;
  vec3 unit;
  int rays, samples, ld, has_dynamic, weighted;
};
