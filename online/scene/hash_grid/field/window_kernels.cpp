// Compiled once per instruction set into namespace HDRCAM_TARGET (see hdrcam_kernels() in CMakeLists.txt).
// Plain loops, which the compiler vectorises: what is not a number is selected away, never branched on.
#include "online/scene/hash_grid/field/window_kernels.h"

#include "hal/core/lane_functions.h"

namespace hdrcam::HDRCAM_TARGET {
namespace {

constexpr float kMaxCodeValue = 255;
constexpr float kDarkest = 1e-5f,
                kBrightest = 1e7f;  // of radiance, so that its logarithm and exponential stay finite

inline bool is_number(float v) { return v - v == 0; }
inline float clamped(float v, float low, float high) {
  v = v > low ? v : low;
  return v < high ? v : high;
}

void values(const ValueRow& row, int n) {
  const float* __restrict codes = row.codes;
  float* __restrict out = row.values;
  const float no_value = row.no_value;
  for (int i = 0; i < n; ++i)
    out[i] = is_number(codes[i]) ? clamped(codes[i] * (1 / kMaxCodeValue), 0, 1) : no_value;
}

void base(const BaseRow& row, int n) {
  const float* __restrict radiance = row.radiance, * __restrict variance = row.variance;
  float* __restrict log_radiance = row.log_radiance, * __restrict gate = row.gate;
  const float sigma2 = row.trusted_sigma * row.trusted_sigma, unseen = row.unseen;
  for (int i = 0; i < n; ++i) {
    const bool known = is_number(radiance[i]);
    const float light = clamped(known ? radiance[i] : 0.f, kDarkest, kBrightest);
    const bool seen = known & is_number(variance[i]) & (variance[i] < unseen);
    const float spread = (seen & (variance[i] > 0)) ? variance[i] : 0.f;
    log_radiance[i] = log_of(light);
    const float trusted = spread / (spread + sigma2 * light * light);
    gate[i] = seen ? trusted : 1.f;
  }
}

// The ray of pixel (x, y) at inverse depth q, in the anchor's camera.
struct Ray {
  float x, y, z;
};
inline Ray in_anchor(const float (*to)[4], float nearest, float x, float y, float q) {
  const float z = to[2][0] * x + to[2][1] * y + to[2][2] + to[2][3] * q;
  return {to[0][0] * x + to[0][1] * y + to[0][2] + to[0][3] * q,
          to[1][0] * x + to[1][1] * y + to[1][2] + to[1][3] * q, z > nearest ? z : nearest};
}

void lift(const LiftedRow& row, int n) {
  float* __restrict u = row.u, * __restrict v = row.v, * __restrict sure = row.sure;
  const float* __restrict dx = row.dx, * __restrict dy = row.dy, * __restrict confidence = row.confidence;
  const float most = row.most;
  for (int i = 0; i < n; ++i) u[i] = is_number(dx[i]) ? clamped(dx[i], -most, most) : 0.f;
  for (int i = 0; i < n; ++i) v[i] = is_number(dy[i]) ? clamped(dy[i], -most, most) : 0.f;
  for (int i = 0; i < n; ++i)
    sure[i] = is_number(dx[i] + dy[i] + confidence[i]) ? clamped(confidence[i], 0, 1) : 0.f;
  const float* __restrict surface = row.surface;
  const float fx = row.focal[0], fy = row.focal[1], per_x = 1 / fx, per_y = 1 / fy, nearest = row.nearest;
  float here[3][4], there[3][4];
  __builtin_memcpy(here, row.here, sizeof here), __builtin_memcpy(there, row.there, sizeof there);
  const float x0 = row.x - row.centre[0], y = row.y - row.centre[1];
  for (int i = 0; i < n; ++i) {
    const float x = x0 + static_cast<float>(i), q = surface[i];
    const Ray start = in_anchor(here, nearest, x * per_x, y * per_y, q);
    const Ray end = in_anchor(there, nearest, (x + u[i]) * per_x, (y + v[i]) * per_y, q);
    u[i] = fx * (end.x / end.z - start.x / start.z);
    v[i] = fy * (end.y / end.z - start.y / start.z);
  }
}

}  // namespace

extern const WindowKernels kWindowKernels;
const WindowKernels kWindowKernels = {values, base, lift};

}  // namespace hdrcam::HDRCAM_TARGET
