// Compiled once per instruction set into namespace HDRCAM_TARGET (see hdrcam_kernels() in CMakeLists.txt).
// Plain loops, which the compiler vectorises: what is not a number is selected away, never branched on.
#include "online/scene/hash_grid/field/window_kernels.h"

#include "hal/core/lane_functions.h"
#include "hal/core/lanes.h"

namespace hdrcam::HDRCAM_TARGET {
namespace {

constexpr float kMaxCodeValue = 255;
// Of radiance, so that its logarithm and exponential stay finite.
constexpr float kDarkest = 1e-5f, kBrightest = 1e7f;

inline bool is_number(float v) { return v - v == 0; }

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
  const float sigma2 = row.trusted_sigma * row.trusted_sigma, unseen_from = row.unseen_from;
  for (int i = 0; i < n; ++i) {
    const bool known = is_number(radiance[i]);
    const float light = clamped(known ? radiance[i] : 0.f, kDarkest, kBrightest);
    const bool seen = known & is_number(variance[i]) & (variance[i] < unseen_from);
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

template <int step>
inline void add_across(const float* __restrict columns, int n, float* __restrict sums) {
  for (int i = 0; i < n; ++i) {
    float sum = 0;
    for (int k = 0; k < step; ++k) sum += columns[i * step + k];
    sums[i] = sum;
  }
}

inline void add_across(int step, float* __restrict columns, int cols, int n, float* __restrict sums) {
  for (int x = cols; x < n * step; ++x) columns[x] = columns[cols - 1];
  switch (step) {
    case 2:
      return add_across<2>(columns, n, sums);
    case 4:
      return add_across<4>(columns, n, sums);
    case 8:
      return add_across<8>(columns, n, sums);
    default:
      return add_across<1>(columns, n, sums);
  }
}

// What a pixel adds to three sums over its block, which read it together.
struct Addends {
  float first, second, third;
};

// The sums over each block of pixel(row, column); `row` is 0..step - 1, `column` counts from the first block.
template <class Pixel>
inline void sum_blocks(int step, int cols, int n, float* first, float* second, float* third, Pixel&& pixel) {
  alignas(64) float columns[3][kMostBlocks * kMostStep];
  for (int x = 0; x < cols; ++x) {
    const Addends add = pixel(0, x);
    columns[0][x] = add.first, columns[1][x] = add.second, columns[2][x] = add.third;
  }
  for (int k = 1; k < step; ++k)
    for (int x = 0; x < cols; ++x) {
      const Addends add = pixel(k, x);
      columns[0][x] += add.first, columns[1][x] += add.second, columns[2][x] += add.third;
    }
  add_across(step, columns[0], cols, n, first);
  add_across(step, columns[1], cols, n, second);
  add_across(step, columns[2], cols, n, third);
}

inline float pixels_of(int step) { return static_cast<float>(step * step); }

void block_values(const ValueBlocks& blocks, int n) {
  const BlockRow& codes = blocks.codes;
  const int step = codes.step, cols = codes.cols;
  alignas(64) float sum[kMostBlocks], missing[kMostBlocks], clipped[kMostBlocks];
  const float bound = blocks.clipped;
  sum_blocks(step, cols, n, sum, missing, clipped, [&](int k, int x) {
    const float code = codes.row[k][x];
    const bool known = is_number(code);
    return Addends{known ? code : 0.f, known ? 0.f : 1.f, code >= bound ? 1.f : 0.f};
  });
  const float all = pixels_of(step), share = 1 / (all * kMaxCodeValue), no_value = blocks.no_value;
  float* __restrict out = blocks.values;
  for (int i = 0; i < n; ++i) {
    const bool in_part = (clipped[i] > 0) & (clipped[i] < all);
    out[i] = (in_part | (missing[i] > 0)) ? no_value : clamped(sum[i] * share, 0, 1);
  }
}

void block_state(const StateBlocks& blocks, int n) {
  const BlockRow &radiance = blocks.radiance, &variance = blocks.variance;
  const int step = radiance.step, cols = radiance.cols;
  const float unseen_from = blocks.unseen_from;
  alignas(64) float light[kMostBlocks], spread[kMostBlocks], lost[kMostBlocks];
  sum_blocks(step, cols, n, light, spread, lost, [&](int k, int x) {
    const float mean = radiance.row[k][x], squared = variance.row[k][x];
    const bool known = is_number(mean + squared) & (squared < unseen_from);
    return Addends{is_number(mean) ? mean : 0.f, squared > 0 ? squared : 0.f, known ? 0.f : 1.f};
  });
  const float share = 1 / pixels_of(step);
  for (int i = 0; i < n; ++i) {
    blocks.mean[i] = light[i] * share;
    blocks.variance_of_mean[i] = lost[i] > 0 ? unseen_from : spread[i] * share * share;
  }
}

void block_flow(const FlowBlocks& blocks, int n) {
  const BlockRow &dx = blocks.dx, &dy = blocks.dy, &confidence = blocks.confidence;
  const int step = dx.step, cols = dx.cols;
  // what is not believed counts a little, so that a block of nothing else has its mean
  constexpr float kLeast = 1e-3f;
  alignas(64) float sum_x[kMostBlocks], sum_y[kMostBlocks], sum_sure[kMostBlocks];
  sum_blocks(step, cols, n, sum_x, sum_y, sum_sure, [&](int k, int x) {
    const float u = dx.row[k][x], v = dy.row[k][x], value = confidence.row[k][x];
    const float sure = is_number(u + v + value) ? clamped(value, 0, 1) : 0.f, weight = sure + kLeast;
    return Addends{is_number(u) ? weight * u : 0.f, is_number(v) ? weight * v : 0.f, sure};
  });
  const float all = pixels_of(step), per_step = 1 / static_cast<float>(step);
  for (int i = 0; i < n; ++i) {
    const float scale = per_step / (sum_sure[i] + kLeast * all);
    blocks.mean_dx[i] = sum_x[i] * scale, blocks.mean_dy[i] = sum_y[i] * scale;
    blocks.confidence_of_mean[i] = sum_sure[i] / all;
  }
}

}  // namespace

extern const WindowKernels kWindowKernels;
const WindowKernels kWindowKernels = {values, base, lift, block_values, block_state, block_flow};

}  // namespace hdrcam::HDRCAM_TARGET
