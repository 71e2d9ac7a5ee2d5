// The hot loops of the field on raw pointers: one table of functions per instruction set, selected at start
// by field_kernels(). Everything is [features, ld] with samples innermost; n is a multiple of kSampleMultiple
// and rows are 64-byte aligned. The scalar twins are in plain_kernels.h; tests compare them. Reentrant. This
// header holds declarations only: the kernels' files may include nothing with inline code (CMakeLists.txt).
#pragma once

#include <cstddef>
#include <cstdint>

namespace hdrcam {

constexpr int kSampleMultiple = 32;

// One level of a hash grid: a lattice of `cells` over [0, 1]^3 whose vertices are rows of a table [slots,
// entries, 2].
struct HashLevel {
  float cells[3];  // cells along u, v, inverse depth; whole numbers
  // A dense level sums vertex * stride, a hashed level combines them by exclusive or.
  std::uint32_t stride[3];
  std::uint32_t entries;  // per slot, a power of two
  bool dense;
};

// The sample positions: u, v, d [n] in window coordinates (clamped to the unit cube) and the table's slot [n]
// (time).
struct GridQuery {
  const float* position[3];
  const std::int32_t* slot;
  int n;
};

// One layer of a network on a batch: rows of `ld` samples, of which the first n count.
struct LayerSize {
  int in, out;  // multiples of 4
  int ld, n;
};

struct AdamStep {
  float rate;  // after bias correction and gradient clipping
  float gradient_scale;
  float beta1, beta2, epsilon;
};

struct FieldKernels {
  // features[0..1][n] <- trilinear interpolation of one level's table
  void (*encode)(const HashLevel&, const float* table, const GridQuery&, float* feature0, float* feature1);
  // table gradient += d_feature spread to the eight corners, samples in order
  void (*scatter)(const HashLevel&, float* d_table, const GridQuery&, const float* d_feature0,
                  const float* d_feature1);
  // d_position[3][n] += d features / d position
  void (*position_backward)(const HashLevel&, const float* table, const GridQuery&, const float* d_feature0,
                            const float* d_feature1, float* const d_position[3]);
  // y[out, n] = W[out, in] x[in, n] + b, negative values set to 0 if relu
  void (*affine)(const LayerSize&, const float* w, const float* b, const float* x, bool relu, float* y);
  // dx[in, n] = W^T dy, zeroed where `active` (the layer's input, after its relu) is 0; active may be null
  void (*affine_transposed)(const LayerSize&, const float* w, const float* dy, const float* active,
                            float* dx);
  // dw[out, in] += dy x^T, db[out] += sum of dy over samples
  void (*outer)(const LayerSize&, const float* dy, const float* x, float* dw, float* db);
  // one Adam step on the entries whose gradient is not zero, then clears the gradient
  void (*adam)(const AdamStep&, std::size_t n, float* parameter, float* gradient, float* mean,
               float* variance);
};

const FieldKernels& field_kernels();

}  // namespace hdrcam
