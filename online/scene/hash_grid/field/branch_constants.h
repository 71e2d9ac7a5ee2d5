// Numbers of the two branches (field.h) that a graphics device (vulkan/, ../fit/vulkan/) has alike: C++ and
// GLSL (hal/gpu/element.glsl).
#ifdef __cplusplus
#pragma once

namespace hdrcam::branch_constants {
#endif

constexpr int kStaticOutputs = 8, kDynamicOutputs = 12;  // of their networks: StaticHead, DynamicHead
// What the kernels have room for, of a network: inputs or hidden values, and parameters.
constexpr int kMostWidth = 64, kMostParameters = 4096;

#ifdef __cplusplus
}  // namespace hdrcam::branch_constants
#endif
