// What the kernels along rays are told: RayConstants of fit_passes.h.
layout(push_constant) uniform Constants {
  vec2 focal, centre, size;
  float margin;
  int rays;
  vec3 unit;  // window units per unit of flow
  int samples, ld, has_dynamic, weighted;
};
