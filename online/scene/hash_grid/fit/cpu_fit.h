// The steps of the fit on the CPU: the gradients of a step's rays, shard by shard, and Adam's step. The same
// bytes for any number of threads: shards and levels are fixed units, and sums have a fixed order. The twin
// on a graphics device is vulkan/vulkan_fit.h. Thread-bound.
#pragma once

#include "hal/core/worker_pool.h"
#include "online/scene/hash_grid/fit/optimised_branch.h"
#include "online/scene/hash_grid/fit/ray_shard.h"
#include "online/scene/hash_grid/fit/step_sums.h"

namespace hdrcam {

class CpuFit {
 public:
  // Room for steps of so many rays, with so many samples each. Allocates only where it is more than before.
  void reserve(const FieldNetworks<float>& networks, int rays, int samples_per_ray);

  // One step's losses and gradients, d_network of the branches among them. rays: whole shards, for as many as
  // reserve() made room.
  void gradients(const StepSetting<float>& step, std::span<const TrainingRay> rays,
                 const ShardStreams& random, WorkerPool& pool, OptimisedBranches& branches, StepSums& sums);
  // Takes the step of the last gradients(): changes the branches' parameters and Adam's moments.
  void take(const AdamStep& table_step, const AdamStep& network_step, WorkerPool& pool,
            OptimisedBranches& branches);

 private:
  std::span<RayShard<float>> used() { return {shards_.data(), used_}; }

  std::vector<RayShard<float>> shards_;  // as many as the largest step so far needed
  int most_samples_ = 0;                 // per ray, capacity of a shard
  // of the last gradients()
  std::size_t used_ = 0;
  bool has_dynamic_ = false;
};

}  // namespace hdrcam
