// Compiled once per instruction set into namespace HDRCAM_TARGET (see hdrcam_kernels() in CMakeLists.txt).
// The matrix products use the compilers' vector type, as wide as this target's register; all other loops are
// plain and vectorised by the compiler (-fopt-info-vec names them).
#include "online/scene/hash_grid/field/field_kernels.h"

#include "hal/core/register_lanes.h"

namespace hdrcam::HDRCAM_TARGET {
namespace {

// ---- hash grid: indices and weights of a block of samples first (arithmetic), then the table (memory)

constexpr int kBlock = 32;
static_assert(kSampleMultiple % kBlock == 0);

struct Corners {
  alignas(64) std::uint32_t index[8][kBlock];
  alignas(64) float fraction[3][kBlock];
  alignas(64) float inside[3][kBlock];  // 1 where the coordinate was not clamped
};

inline void find_corners(const HashLevel& level, const GridQuery& at, int first, Corners& corners) {
  alignas(64) std::uint32_t low[3][kBlock], high[3][kBlock];
  for (int axis = 0; axis < 3; ++axis) {
    const float* position = at.position[axis] + first;
    const float cells = level.cells[axis], last = level.cells[axis] * 0.999999f;
    const std::uint32_t stride = level.stride[axis];
    for (int s = 0; s < kBlock; ++s) {
      const float raw = position[s] * cells;
      float x = raw < last ? raw : last;
      x = x > 0 ? x : 0;
      const auto vertex = static_cast<std::int32_t>(x);
      corners.fraction[axis][s] = x - static_cast<float>(vertex);
      corners.inside[axis][s] = x == raw ? 1.f : 0.f;
      low[axis][s] = static_cast<std::uint32_t>(vertex) * stride;
      high[axis][s] = low[axis][s] + stride;
    }
  }
  const std::uint32_t mask = level.entries - 1;
  for (int corner = 0; corner < 8; ++corner) {
    const std::uint32_t* a = corner & 1 ? high[0] : low[0];
    const std::uint32_t* b = corner & 2 ? high[1] : low[1];
    const std::uint32_t* c = corner & 4 ? high[2] : low[2];
    const std::int32_t* slot = at.slot + first;
    if (level.dense)
      for (int s = 0; s < kBlock; ++s)
        corners.index[corner][s] = (a[s] + b[s] + c[s]) + static_cast<std::uint32_t>(slot[s]) * level.entries;
    else
      for (int s = 0; s < kBlock; ++s)
        corners.index[corner][s] =
            ((a[s] ^ b[s] ^ c[s]) & mask) + static_cast<std::uint32_t>(slot[s]) * level.entries;
  }
}

inline void corner_weights(const Corners& corners, int corner, float* weight) {
  for (int s = 0; s < kBlock; ++s) {
    const float u = corners.fraction[0][s], v = corners.fraction[1][s], d = corners.fraction[2][s];
    weight[s] = (corner & 1 ? u : 1 - u) * (corner & 2 ? v : 1 - v) * (corner & 4 ? d : 1 - d);
  }
}

// The corners of a block of samples, and what each counts in the interpolation.
struct WeighedCorners : Corners {
  alignas(64) float weight[8][kBlock];
};
inline void weigh_corners(const HashLevel& level, const GridQuery& at, int first, WeighedCorners& corners) {
  find_corners(level, at, first, corners);
  for (int corner = 0; corner < 8; ++corner) corner_weights(corners, corner, corners.weight[corner]);
}

void encode(const HashLevel& level, const float* table, const GridQuery& at, float* feature0,
            float* feature1) {
  WeighedCorners corners;
  for (int first = 0; first < at.n; first += kBlock) {
    weigh_corners(level, at, first, corners);
    for (int s = 0; s < kBlock; ++s) {
      Pair sum{};
      for (int corner = 0; corner < 8; ++corner)
        sum += load_pair(table + 2 * corners.index[corner][s]) * (Pair{} + corners.weight[corner][s]);
      feature0[first + s] = sum[0], feature1[first + s] = sum[1];
    }
  }
}

void scatter(const HashLevel& level, float* d_table, const GridQuery& at, const float* d_feature0,
             const float* d_feature1) {
  WeighedCorners corners;
  for (int first = 0; first < at.n; first += kBlock) {
    weigh_corners(level, at, first, corners);
    for (int s = 0; s < kBlock; ++s) {
      const float d0 = d_feature0[first + s], d1 = d_feature1[first + s];
      for (int corner = 0; corner < 8; ++corner) {
        float* entry = d_table + 2 * corners.index[corner][s];
        entry[0] += corners.weight[corner][s] * d0;
        entry[1] += corners.weight[corner][s] * d1;
      }
    }
  }
}

void position_backward(const HashLevel& level, const float* table, const GridQuery& at,
                       const float* d_feature0, const float* d_feature1, float* const d_position[3]) {
  Corners corners;
  alignas(64) float q[8][kBlock];
  for (int first = 0; first < at.n; first += kBlock) {
    find_corners(level, at, first, corners);
    for (int corner = 0; corner < 8; ++corner)
      for (int s = 0; s < kBlock; ++s) {
        const std::uint32_t entry = 2 * corners.index[corner][s];
        q[corner][s] = d_feature0[first + s] * table[entry] + d_feature1[first + s] * table[entry + 1];
      }
    for (int s = 0; s < kBlock; ++s) {
      const float u = corners.fraction[0][s], v = corners.fraction[1][s], d = corners.fraction[2][s];
      const float u0 = (1 - v) * (1 - d), u1 = v * (1 - d), u2 = (1 - v) * d, u3 = v * d;
      const float along_u = u0 * (q[1][s] - q[0][s]) + u1 * (q[3][s] - q[2][s]) + u2 * (q[5][s] - q[4][s]) +
                            u3 * (q[7][s] - q[6][s]);
      const float v0 = (1 - u) * (1 - d), v1 = u * (1 - d), v2 = (1 - u) * d, v3 = u * d;
      const float along_v = v0 * (q[2][s] - q[0][s]) + v1 * (q[3][s] - q[1][s]) + v2 * (q[6][s] - q[4][s]) +
                            v3 * (q[7][s] - q[5][s]);
      const float d0 = (1 - u) * (1 - v), d1 = u * (1 - v), d2 = (1 - u) * v, d3 = u * v;
      const float along_d = d0 * (q[4][s] - q[0][s]) + d1 * (q[5][s] - q[1][s]) + d2 * (q[6][s] - q[2][s]) +
                            d3 * (q[7][s] - q[3][s]);
      d_position[0][first + s] += along_u * level.cells[0] * corners.inside[0][s];
      d_position[1][first + s] += along_v * level.cells[1] * corners.inside[1][s];
      d_position[2][first + s] += along_d * level.cells[2] * corners.inside[2][s];
    }
  }
}

// ---- matrix products: a tile of 4 outputs x 2 registers of samples stays in registers over the whole inner
// sum

void affine(const LayerSize& size, const float* w, const float* b, const float* x, bool relu, float* y) {
  const int in = size.in, out = size.out, ld = size.ld, n = size.n;
  for (int s = 0; s < n; s += 2 * kLanes)
    for (int o = 0; o < out; o += 4) {
      Lanes a0 = splat(b[o]), a1 = splat(b[o + 1]), a2 = splat(b[o + 2]), a3 = splat(b[o + 3]);
      Lanes c0 = a0, c1 = a1, c2 = a2, c3 = a3;
      const float* weight = w + o * in;
      for (int i = 0; i < in; ++i) {
        const Lanes p = load(x + i * ld + s), q = load(x + i * ld + s + kLanes);
        const Lanes w0 = splat(weight[i]), w1 = splat(weight[in + i]);
        const Lanes w2 = splat(weight[2 * in + i]), w3 = splat(weight[3 * in + i]);
        a0 += w0 * p, a1 += w1 * p, a2 += w2 * p, a3 += w3 * p;
        c0 += w0 * q, c1 += w1 * q, c2 += w2 * q, c3 += w3 * q;
      }
      const Lanes zero{};
      if (relu) {
        a0 = a0 > zero ? a0 : zero, a1 = a1 > zero ? a1 : zero, a2 = a2 > zero ? a2 : zero,
        a3 = a3 > zero ? a3 : zero;
        c0 = c0 > zero ? c0 : zero, c1 = c1 > zero ? c1 : zero, c2 = c2 > zero ? c2 : zero,
        c3 = c3 > zero ? c3 : zero;
      }
      float* row = y + o * ld + s;
      store(row, a0), store(row + ld, a1), store(row + 2 * ld, a2), store(row + 3 * ld, a3);
      row += kLanes;
      store(row, c0), store(row + ld, c1), store(row + 2 * ld, c2), store(row + 3 * ld, c3);
    }
}

void affine_transposed(const LayerSize& size, const float* w, const float* dy, const float* active,
                       float* dx) {
  const int in = size.in, out = size.out, ld = size.ld, n = size.n;
  for (int s = 0; s < n; s += 2 * kLanes)
    for (int i = 0; i < in; i += 4) {
      Lanes a0{}, a1{}, a2{}, a3{}, c0{}, c1{}, c2{}, c3{};
      for (int o = 0; o < out; ++o) {
        const float* weight = w + o * in + i;
        const Lanes p = load(dy + o * ld + s), q = load(dy + o * ld + s + kLanes);
        const Lanes w0 = splat(weight[0]), w1 = splat(weight[1]), w2 = splat(weight[2]),
                    w3 = splat(weight[3]);
        a0 += w0 * p, a1 += w1 * p, a2 += w2 * p, a3 += w3 * p;
        c0 += w0 * q, c1 += w1 * q, c2 += w2 * q, c3 += w3 * q;
      }
      float* row = dx + i * ld + s;
      if (active != nullptr) {
        const Lanes zero{};
        const float* on = active + i * ld + s;
        a0 = load(on) > zero ? a0 : zero, a1 = load(on + ld) > zero ? a1 : zero;
        a2 = load(on + 2 * ld) > zero ? a2 : zero, a3 = load(on + 3 * ld) > zero ? a3 : zero;
        on += kLanes;
        c0 = load(on) > zero ? c0 : zero, c1 = load(on + ld) > zero ? c1 : zero;
        c2 = load(on + 2 * ld) > zero ? c2 : zero, c3 = load(on + 3 * ld) > zero ? c3 : zero;
      }
      store(row, a0), store(row + ld, a1), store(row + 2 * ld, a2), store(row + 3 * ld, a3);
      row += kLanes;
      store(row, c0), store(row + ld, c1), store(row + 2 * ld, c2), store(row + 3 * ld, c3);
    }
}

void outer(const LayerSize& size, const float* dy, const float* x, float* dw, float* db) {
  const int in = size.in, out = size.out, ld = size.ld, n = size.n;
  for (int o = 0; o < out; o += 4) {
    const float *g0 = dy + o * ld, *g1 = g0 + ld, *g2 = g1 + ld, *g3 = g2 + ld;
    for (int i = 0; i < in; i += 2) {
      const float *x0 = x + i * ld, *x1 = x0 + ld;
      Lanes a0{}, a1{}, a2{}, a3{}, c0{}, c1{}, c2{}, c3{};
      for (int s = 0; s < n; s += kLanes) {
        const Lanes p = load(x0 + s), q = load(x1 + s);
        const Lanes e0 = load(g0 + s), e1 = load(g1 + s), e2 = load(g2 + s), e3 = load(g3 + s);
        a0 += e0 * p, a1 += e1 * p, a2 += e2 * p, a3 += e3 * p;
        c0 += e0 * q, c1 += e1 * q, c2 += e2 * q, c3 += e3 * q;
      }
      float* row = dw + o * in + i;
      row[0] += sum(a0), row[in] += sum(a1), row[2 * in] += sum(a2), row[3 * in] += sum(a3);
      row[1] += sum(c0), row[in + 1] += sum(c1), row[2 * in + 1] += sum(c2), row[3 * in + 1] += sum(c3);
    }
    Lanes b0{}, b1{}, b2{}, b3{};
    for (int s = 0; s < n; s += kLanes)
      b0 += load(g0 + s), b1 += load(g1 + s), b2 += load(g2 + s), b3 += load(g3 + s);
    db[o] += sum(b0), db[o + 1] += sum(b1), db[o + 2] += sum(b2), db[o + 3] += sum(b3);
  }
}

// ---- Adam on the entries that a step touched

void adam_block(const AdamStep& step, int n, float* __restrict parameter, float* __restrict gradient,
                float* __restrict mean, float* __restrict variance) {
  for (int i = 0; i < n; ++i) {
    const float g = gradient[i] * step.gradient_scale;
    const float m = step.beta1 * mean[i] + (1 - step.beta1) * g;
    const float v = step.beta2 * variance[i] + (1 - step.beta2) * g * g;
    const float moved = parameter[i] - step.rate * m / (__builtin_sqrtf(v) + step.epsilon);
    const bool touched = gradient[i] != 0;
    mean[i] = touched ? m : mean[i];
    variance[i] = touched ? v : variance[i];
    parameter[i] = touched ? moved : parameter[i];
    gradient[i] = 0;
  }
}

void adam(const AdamStep& step, std::size_t n, float* parameter, float* gradient, float* mean,
          float* variance) {
  constexpr std::size_t kRun = 128;
  for (std::size_t i = 0; i < n; i += kRun) {
    const std::size_t run = n - i < kRun ? n - i : kRun;
    int touched = 0;
    for (std::size_t j = 0; j < run; ++j) touched |= gradient[i + j] != 0;
    if (touched != 0)
      adam_block(step, static_cast<int>(run), parameter + i, gradient + i, mean + i, variance + i);
  }
}

}  // namespace

extern const FieldKernels kFieldKernels;
const FieldKernels kFieldKernels = {encode, scatter, position_backward, affine, affine_transposed,
                                    outer,  adam};

}  // namespace hdrcam::HDRCAM_TARGET
