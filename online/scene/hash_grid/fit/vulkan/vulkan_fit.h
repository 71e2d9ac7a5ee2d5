// The steps of the fit on a graphics device: forward and backward pass, scatter and Adam there, losses here.
// Between begin() and collect() the parameters there are ahead of those here, which stay as they were: who
// loses the device goes on from them. It takes the device's turn for each call. Thread-bound but for that;
// the device outlives it.
//
// Errors of all calls: those of the device, and Unsupported for a network or a window that is too large for
// it.
#pragma once

#include <memory>
#include <optional>

#include "hal/core/worker_pool.h"
#include "online/scene/hash_grid/fit/step_sums.h"
#include "online/scene/hash_grid/fit/vulkan/fit_passes.h"

namespace hdrcam {

// What the steps between begin() and collect() have in common.
struct StepSize {
  int rays, samples_per_ray;
  bool has_dynamic;  // without it the dynamic branch stays on the CPU
};

class VulkanFit {
 public:
  static Result<std::unique_ptr<VulkanFit>> make(GpuDevice& device, const FieldNetworks<float>& networks);

  ~VulkanFit();

  // The parameters with their moments, and the window that they are fitted to. What was there is forgotten.
  Result<void> begin(const WindowFrames& window, const OptimisedBranches& branches, const StepSize& most);
  // One step's losses and gradients, d_network of the branches among them. rays: whole shards. Until
  // collect(), steps have as many rays, samples and branches as the one before them.
  Result<void> gradients(const StepSetting<float>& step, std::span<const TrainingRay> rays,
                         const ShardStreams& random, WorkerPool& pool, OptimisedBranches& branches,
                         StepSums& sums);
  // Takes the step of the last gradients(); it is on its way with the next call.
  void take(const AdamStep& table_step, const AdamStep& network_step) { due_ = {table_step, network_step}; }
  // The parameters with their moments as the steps have left them. On an error they stay as they were.
  Result<void> collect(OptimisedBranches& branches);

 private:
  struct Due {
    AdamStep table_step, network_step;
  };
  // What comes back of a branch's gradients.
  struct Fetched {
    std::vector<float> d_network, energy;
  };

  VulkanFit(GpuDevice& device, FitPasses passes, GpuBranch static_branch, GpuBranch dynamic_branch)
      : device_(device),
        passes_(passes),
        static_(std::move(static_branch)),
        dynamic_(std::move(dynamic_branch)) {}
  Result<void> forward(const StepSetting<float>& step);
  Result<void> backward(OptimisedBranches& branches, StepSums& sums);
  void losses(const StepSetting<float>& step, std::span<const TrainingRay> rays, WorkerPool& pool,
              StepSums& sums);
  void record_due();
  void fetch(const GpuBranch& branch, int count, Fetched& fetched);

  GpuDevice& device_;
  FitPasses passes_;
  GpuBranch static_, dynamic_;
  GpuRays rays_;
  std::optional<Due> due_;
  std::vector<ShardLosses<float>> shard_losses_;  // by shard
  Fetched fetched_static_, fetched_dynamic_;
  GpuBranch::Arrival arrived_static_, arrived_dynamic_;
};

}  // namespace hdrcam
