// What every kernel of the probe is told: VulkanProbe::Constants of vulkan_probe.cpp.
layout(push_constant) uniform Constants {
  vec2 focal, centre, size;
  float margin, offset;
  vec3 unit;
  int rays, samples, ld, has_dynamic, weighted;
};
