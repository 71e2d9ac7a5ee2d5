// The dense flow's passes on a graphics device: one method per kernel, each with a twin on the processor
// (named beside it). Both directions are one call: vectors are [u v there, u v back, ..]. A pass is recorded
// into the device's work; nothing runs before its finish(). Thread-bound; the device outlives it.
#pragma once

#include <array>

#include "hal/gpu/gpu_picture.h"
#include "online/priors/motion/dense_flow.h"
#include "online/priors/motion/flow_kernels.h"

namespace hdrcam {

// Planes, of both pictures or of both directions.
constexpr int kFlowLevelPlanes = 6;    // gray, dx, dy of a and of b
constexpr int kFlowVectorPlanes = 4;   // u, v
constexpr int kFlowDataPlanes = 6;     // dt, dx, dy
constexpr int kFlowSystemPlanes = 12;  // a12, c1, c2, inverse_u, inverse_v, link

// Both pictures at one scale, and where its patches are.
struct GpuFlowLevel {
  const GpuPicture& pictures;  // [kFlowLevelPlanes]
  PatchGrid grid;
  int scale;  // 0: full size
};

// FlowGuess of both directions: planes of `vectors` from `first` on.
struct GpuFlowGuess {
  const GpuPicture& vectors;
  struct Direction {
    bool given = false, carried = false;
    int first = 0;
    float share = 1;
  };
  std::array<Direction, 2> directions;
};

// A flow of both directions in the first samples of a buffer; rows 0: none.
struct GpuFlow {
  const GpuBuffer& buffer;
  int rows, cols;
};

class FlowPasses {
 public:
  FlowPasses() = default;  // none yet
  static Result<FlowPasses> make(GpuDevice& device);

  // FlowKernels::halve
  void halve(const GpuPicture& finer, const GpuPicture& level) const;
  // FlowKernels::derive
  void derive(const GpuPicture& level) const;
  // CpuFlow::prepare
  void start(const GpuFlowLevel& level, const GpuFlowGuess& guess, const GpuFlow& coarser,
             const GpuBuffer& patches, const GpuBuffer& starts) const;
  // FlowKernels::search; starts count where a direction is guided; others: null for none
  void search(const GpuFlowLevel& level, int steps, std::array<bool, 2> guided, const GpuBuffer& starts,
              const GpuBuffer* others, const GpuBuffer& patches) const;
  // FlowKernels::search_far
  void search_far(const GpuFlowLevel& level, const GpuBuffer& patches, const GpuBuffer& far) const;
  // FlowKernels::spread
  void spread(const GpuFlowLevel& level, const GpuBuffer& patches, const GpuBuffer& flow) const;

  // The steps of RefinementKernels::refine: linearise once, weigh once a round, then the round's sweeps, each
  // from `flow` to `next`.
  void linearise(const GpuPicture& level, const GpuBuffer& flow, const GpuBuffer& data) const;
  void weigh(const GpuPicture& level, const GpuBuffer& data, const GpuBuffer& before, const GpuBuffer& flow,
             const GpuBuffer& system) const;
  void sweep(const GpuPicture& level, const GpuBuffer& system, const GpuBuffer& flow,
             const GpuBuffer& next) const;

  // CpuFlow::enlarge
  void enlarge(const GpuFlow& half, const GpuFlow& whole) const;

 private:
  enum Pass : std::size_t {
    kHalve,
    kDerive,
    kStart,
    kSearch,
    kSearchFar,
    kSpread,
    kLinearise,
    kWeigh,
    kRelax,
    kEnlarge,
    kPasses
  };
  explicit FlowPasses(GpuDevice& device) : device_(&device) {}
  template <class Constants>
  void run(Pass pass, std::initializer_list<const GpuBuffer*> buffers, const Constants& constants,
           const GpuGrid& grid) const {
    device_->work().run(*kernels_[pass], buffers, constants, grid);
  }

  GpuDevice* device_ = nullptr;
  std::array<const GpuKernel*, kPasses> kernels_{};
};

}  // namespace hdrcam
