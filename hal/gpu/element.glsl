// What every kernel of ours begins with: one invocation per element of a grid, innermost axis first, and
// buffers of floats. The size of a work group is the device's choice (GpuFacts::group), but for kernels whose
// invocations work together: these define GROUP before (GpuShader::group).
//
// Numbers that a kernel and its twin on the processor must have alike stand in a header that is C++ and GLSL.
#define constexpr const

#ifdef GROUP
layout(local_size_x = GROUP, local_size_y = 1, local_size_z = 1) in;
#else
layout(local_size_x_id = 0, local_size_y = 1, local_size_z = 1) in;
#endif

#define READS(place, block, name) \
  layout(std430, set = 0, binding = place) readonly buffer block { float name[]; };
#define WRITES(place, block, name) \
  layout(std430, set = 0, binding = place) writeonly buffer block { float name[]; };
#define CHANGES(place, block, name) \
  layout(std430, set = 0, binding = place) buffer block { float name[]; };

int column() { return int(gl_GlobalInvocationID.x); }
int row() { return int(gl_GlobalInvocationID.y); }
int plane() { return int(gl_GlobalInvocationID.z); }
