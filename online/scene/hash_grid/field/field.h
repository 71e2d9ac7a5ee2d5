// The radiance field of the window: two branches, each a hash grid and a small network, over the base of the
// frames.
//   static (u, v, d)      -> density, log radiance residual (3), blending weight v
//   dynamic (u, v, d, t)  -> density, log radiance residual (3), scene flow to the next and the previous
//                            frame (6), occlusion weights (2)
// A sample's radiance is exp(base + gate * residual), where base and gate are read from the frame's planes at
// the pixel that sees the sample: unbounded, and with an untrained network exactly the state's picture. Scene
// flow is base flow + residual. Scalar type T as in hash_grid.h. Evaluation is reentrant, each caller with
// its own passes.
#pragma once

#include "online/scene/hash_grid/field/branch_constants.h"
#include "online/scene/hash_grid/field/compositing.h"
#include "online/scene/hash_grid/field/hash_grid.h"
#include "online/scene/hash_grid/field/mlp.h"
#include "online/scene/hash_grid/field/window.h"

namespace hdrcam {

enum class Blend {
  DensitySum,  // densities add up
  Weight,      // the paper's: v sigma_static and (1 - v) sigma_dynamic
};

// One branch alone is for ablation.
enum class Branches { Both, Static, Dynamic };

struct FieldShape {
  // A fit sets the dynamic slots by its window, and both v_ratios by the shape of the picture.
  HashGridShape static_grid;
  HashGridShape dynamic_grid{
      .levels = 4, .log2_entries = 13, .slots = 8, .finest_cells = 160, .d_ratio = 0.125f};
  int hidden = 32;  // neurons per hidden layer, a multiple of 4
  Blend blend = Blend::DensitySum;
  Branches branches = Branches::Both;
};

struct StaticHead {
  enum : int { kDensity = 0, kResidual = 1, kBlend = 4, kCount = branch_constants::kStaticOutputs };
};
struct DynamicHead {
  enum : int {
    kDensity = 0,
    kResidual = 1,
    kFlow = 4,
    kOcclusion = 10,
    kCount = branch_constants::kDynamicOutputs
  };
};

template <class T>
struct Branch {
  HashGrid<T> grid;
  Mlp<T> mlp;

  // The grid's entries begin at random within this of 0: almost no residual. Müller et al. take 1e-4.
  static constexpr float kEntrySpread = 1e-2f;

  Branch(const HashGridShape& shape, int hidden, int outputs, float head_gain, Pcg32& random)
      : grid(shape, kEntrySpread, random), mlp(grid.features(), hidden, outputs, head_gain, random) {}
  // copies the parameters of a branch of the same shape, without gradients
  void copy_parameters(const Branch& from) {
    HDRCAM_CHECK(grid.shape() == from.grid.shape());
    grid.tables().copy_from(from.grid.tables());
    std::copy(from.mlp.parameters().begin(), from.mlp.parameters().end(), mlp.parameters().begin());
  }
};

template <class T>
struct FieldNetworks {
  Branch<T> static_, dynamic;
  Blend blend;

  FieldNetworks(const FieldShape& shape, Pcg32& random)
      : static_(shape.static_grid, shape.hidden, StaticHead::kCount, kHeadGain, random),
        dynamic(shape.dynamic_grid, shape.hidden, DynamicHead::kCount, kHeadGain, random),
        blend(shape.blend) {
    for (int k = 0; k < 2; ++k) dynamic.mlp.head_bias(DynamicHead::kOcclusion + k) = T(kVisible);
    if (shape.branches == Branches::Dynamic) static_.mlp.head_bias(StaticHead::kDensity) = T(kNowhere);
  }
  void copy_parameters(const FieldNetworks& from) {
    static_.copy_parameters(from.static_);
    dynamic.copy_parameters(from.dynamic);
  }
  static constexpr float kHeadGain = 0.1f;
  static constexpr float kVisible = 3;    // occlusion weights at first, before the sigmoid: 0.95
  static constexpr float kNowhere = -60;  // log density, far below its bound: neither seen nor fitted
};

// The least multiple of kSampleMultiple that holds so many samples.
constexpr int whole_runs(int samples) {
  return (samples + kSampleMultiple - 1) / kSampleMultiple * kSampleMultiple;
}

// One evaluation of a branch on up to ld samples, with the activations that backward needs. All images are
// [width, 1, ld].
template <class T>
struct BranchPass {
  Image<T> position, features, raw;
  Image<T> d_position, d_features, d_raw;
  MlpTrace<T> trace;
  std::vector<std::int32_t> slot;
  int n = 0;  // a multiple of kSampleMultiple

  void reserve(const Branch<T>& branch, int ld) {
    position = Image<T>(3, 1, ld);
    features = Image<T>(branch.mlp.inputs(), 1, ld);
    raw = Image<T>(branch.mlp.outputs(), 1, ld);
    for (Image<T>& hidden : trace.hidden) hidden = Image<T>(branch.mlp.hidden(), 1, ld);
    slot.assign(static_cast<std::size_t>(ld), 0);
  }
  // Beside reserve(): the room of backward().
  void reserve_gradient(const Branch<T>& branch, int ld) {
    d_position = Image<T>(3, 1, ld);
    d_features = Image<T>(branch.mlp.inputs(), 1, ld);
    d_raw = Image<T>(branch.mlp.outputs(), 1, ld);
    for (Image<T>& d_hidden : trace.d_hidden) d_hidden = Image<T>(branch.mlp.hidden(), 1, ld);
  }
  GridSamples<T> samples() const { return {position, slot, n}; }

  void forward(const Branch<T>& branch) {
    branch.grid.encode(samples(), features);
    branch.mlp.forward(features, n, trace, raw);
  }
  // d_raw -> d_features and d_parameters; d_raw of unused samples must be 0
  void backward(const Branch<T>& branch, std::span<T> d_parameters) {
    branch.mlp.backward(features, d_raw, n, trace, d_parameters, d_features);
  }
};

}  // namespace hdrcam
