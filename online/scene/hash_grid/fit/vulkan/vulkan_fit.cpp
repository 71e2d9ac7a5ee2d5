#include "online/scene/hash_grid/fit/vulkan/vulkan_fit.h"

#include "online/scene/hash_grid/field/vulkan/branch_layout.h"

namespace hdrcam {
namespace {

double sum_of(std::span<const float> values) {
  double sum = 0;
  for (const float value : values) sum += static_cast<double>(value);
  return sum;
}

}  // namespace

Result<std::unique_ptr<VulkanFit>> VulkanFit::make(GpuDevice& device, const FieldNetworks<float>& networks) {
  const GpuTurn turn(device);
  FitPasses passes = TRY(FitPasses::make(device));
  GpuBranch static_branch = TRY(GpuBranch::make(device, networks.static_, 0));
  GpuBranch dynamic_branch = TRY(GpuBranch::make(device, networks.dynamic, branch_constants::kStaticOutputs));
  return std::unique_ptr<VulkanFit>(
      new VulkanFit(device, passes, std::move(static_branch), std::move(dynamic_branch)));
}

VulkanFit::~VulkanFit() {
  const GpuTurn turn(device_);
  static_ = {}, dynamic_ = {}, rays_ = {};
}

Result<void> VulkanFit::begin(const WindowFrames& window, const OptimisedBranches& branches,
                              const StepSize& most) {
  const GpuTurn turn(device_);
  due_.reset();
  const int ld = 2 * most.rays * most.samples_per_ray;
  TRY(rays_.reserve(device_, window, most.rays, most.samples_per_ray));
  TRY(static_.reserve(device_, ld));
  TRY(dynamic_.reserve(device_, ld));
  GpuWork& work = device_.work();
  rays_.upload_window(work, window);
  static_.upload(work, branches.static_);
  if (most.has_dynamic) dynamic_.upload(work, branches.dynamic);
  return work.finish();
}

Result<void> VulkanFit::gradients(const StepSetting<float>& step, std::span<const TrainingRay> rays,
                                  const ShardStreams& random, WorkerPool& pool, OptimisedBranches& branches,
                                  StepSums& sums) {
  HDRCAM_CHECK(rays.size() % kRaysPerShard == 0);
  const std::size_t shards = rays.size() / kRaysPerShard;
  HDRCAM_CHECK(!due_ || rays_.is_alike(step, rays.size()));
  rays_.begin(step, rays.size());
  pool.for_each(static_cast<int>(shards), [&](int i) {
    const auto shard = static_cast<std::size_t>(i), first = shard * kRaysPerShard;
    rays_.place(step, rays.subspan(first, kRaysPerShard), first, random.of(shard));
  });
  TRY(forward(step));
  losses(step, rays, pool, sums);
  return backward(branches, sums);
}

// From the rays to what is seen along them.
Result<void> VulkanFit::forward(const StepSetting<float>& step) {
  const GpuTurn turn(device_);
  GpuWork& work = device_.work();
  record_due();
  const int n = rays_.count();
  rays_.upload_placed(work);
  passes_.forward(static_, rays_, {0, n});
  if (step.has_dynamic) {
    passes_.forward(dynamic_, rays_, {0, n});
    passes_.follow(rays_);
    passes_.forward(dynamic_, rays_, {n, n});
  }
  passes_.render(rays_);
  rays_.download_seen(work);
  return work.finish();
}

void VulkanFit::losses(const StepSetting<float>& step, std::span<const TrainingRay> rays, WorkerPool& pool,
                       StepSums& sums) {
  const std::size_t shards = rays.size() / kRaysPerShard;
  shard_losses_.resize(shards);
  sums.begin(rays.size());
  pool.for_each(static_cast<int>(shards), [&](int i) {
    const auto shard = static_cast<std::size_t>(i), first = shard * kRaysPerShard;
    shard_losses_[shard] = {};
    rays_.losses(step, rays.subspan(first, kRaysPerShard), first, shard_losses_[shard],
                 std::span(sums.misfits).subspan(first, kRaysPerShard));
  });
  for (const ShardLosses<float>& shard : shard_losses_)
    sums.add(shard.losses, step.fits_response ? &shard.d_response : nullptr);
}

// From the losses' gradient to that of the parameters. The displaced samples come first: what they say of
// their places is a part of the gradient of those that displaced them.
Result<void> VulkanFit::backward(OptimisedBranches& branches, StepSums& sums) {
  const GpuTurn turn(device_);
  GpuWork& work = device_.work();
  const int n = rays_.count();
  rays_.upload_d_seen(work);
  passes_.composite_backward(rays_);
  if (rays_.has_dynamic()) {
    passes_.backward(dynamic_, rays_, {n, n});
    passes_.warp_backward(dynamic_, rays_);
    passes_.backward(dynamic_, rays_, {0, n});
    passes_.add_up(dynamic_, rays_.ld(), 2 * n);
    fetch(dynamic_, 2 * n, fetched_dynamic_);
  }
  passes_.backward(static_, rays_, {0, n});
  passes_.add_up(static_, rays_.ld(), n);
  fetch(static_, n, fetched_static_);
  TRY(work.finish());
  untile(branches.static_.branch.mlp, fetched_static_.d_network, branches.static_.d_network);
  sums.feature_energy += sum_of(fetched_static_.energy);
  OptimisedBranch& dynamic = branches.dynamic;
  if (rays_.has_dynamic()) {
    untile(dynamic.branch.mlp, fetched_dynamic_.d_network, dynamic.d_network);
    sums.feature_energy += sum_of(fetched_dynamic_.energy);
  } else {
    std::fill(dynamic.d_network.begin(), dynamic.d_network.end(), 0.f);
  }
  return {};
}

void VulkanFit::fetch(const GpuBranch& branch, int count, Fetched& fetched) {
  fetched.d_network.resize(static_cast<std::size_t>(branch.parameters));
  fetched.energy.resize(static_cast<std::size_t>(branch.inputs) *
                        static_cast<std::size_t>(GpuBranch::chunks(count)));
  device_.work().download(**branch.d_network, std::as_writable_bytes(std::span(fetched.d_network)));
  device_.work().download(**branch.energy, std::as_writable_bytes(std::span(fetched.energy)));
}

void VulkanFit::record_due() {
  if (!due_) return;
  const auto apply = [&](const GpuBranch& branch, int count) {
    passes_.scatter(branch, rays_, count);
    passes_.adam(branch, due_->table_step, due_->network_step, count);
  };
  apply(static_, rays_.count());
  if (rays_.has_dynamic()) apply(dynamic_, 2 * rays_.count());
  due_.reset();
}

Result<void> VulkanFit::collect(OptimisedBranches& branches) {
  const GpuTurn turn(device_);
  GpuWork& work = device_.work();
  record_due();
  static_.download(work, branches.static_, arrived_static_);
  if (rays_.has_dynamic()) dynamic_.download(work, branches.dynamic, arrived_dynamic_);
  TRY(work.finish());
  GpuBranch::take(arrived_static_, branches.static_);
  if (rays_.has_dynamic()) GpuBranch::take(arrived_dynamic_, branches.dynamic);
  return {};
}

}  // namespace hdrcam
