#include "online/scene/hash_grid/fit/cpu_fit.h"

namespace hdrcam {

void CpuFit::reserve(const FieldNetworks<float>& networks, int rays, int samples_per_ray) {
  if (samples_per_ray > most_samples_) shards_.clear(), most_samples_ = samples_per_ray;
  while (static_cast<int>(shards_.size()) * kRaysPerShard < rays)
    shards_.emplace_back(networks, kRaysPerShard, most_samples_);
}

void CpuFit::gradients(const StepSetting<float>& step, std::span<const TrainingRay> rays,
                       const ShardStreams& random, WorkerPool& pool, OptimisedBranches& branches,
                       StepSums& sums) {
  used_ = rays.size() / kRaysPerShard;
  has_dynamic_ = step.has_dynamic;
  HDRCAM_CHECK(used_ <= shards_.size());
  pool.for_each(static_cast<int>(used_), [&](int i) {
    const auto at = static_cast<std::size_t>(i);
    shards_[at].run(step, rays.subspan(at * kRaysPerShard, kRaysPerShard), random.of(at));
  });

  // in the order of the shards
  sums.begin(rays.size());
  for (OptimisedBranch* part : branches.both())
    std::fill(part->d_network.begin(), part->d_network.end(), 0.f);
  std::vector<float>&d_static = branches.static_.d_network, &d_dynamic = branches.dynamic.d_network;
  auto misfit = sums.misfits.begin();
  for (RayShard<float>& shard : used()) {
    sums.add(shard.losses(), step.fits_response ? &shard.d_response() : nullptr);
    for (std::size_t i = 0; i < d_static.size(); ++i) d_static[i] += shard.d_static()[i];
    for (std::size_t i = 0; i < d_dynamic.size(); ++i) d_dynamic[i] += shard.d_dynamic()[i];
    sums.feature_energy += shard.feature_energy();
    misfit = std::copy_n(shard.misfits().begin(), kRaysPerShard, misfit);
  }
}

void CpuFit::take(const AdamStep& table_step, const AdamStep& network_step, WorkerPool& pool,
                  OptimisedBranches& branches) {
  const int static_levels = branches.static_.branch.grid.shape().levels;
  const int dynamic_levels = has_dynamic_ ? branches.dynamic.branch.grid.shape().levels : 0;
  pool.for_each(static_levels + dynamic_levels, [&](int i) {
    const bool is_static = i < static_levels;
    OptimisedBranch& part = is_static ? branches.static_ : branches.dynamic;
    const int level = is_static ? i : i - static_levels;
    HashGrid<float>& grid = part.branch.grid;
    for (const RayShard<float>& shard : used())
      is_static ? shard.scatter_static(level, grid) : shard.scatter_dynamic(level, grid);
    apply_adam(table_step, grid.table(level), grid.d_table(level), part.table_mean.plane(level),
               part.table_variance.plane(level));
  });
  for (OptimisedBranch* part : branches.both())
    apply_adam(network_step, part->branch.mlp.parameters(), part->d_network, part->network.mean.data(),
               part->network.variance.data());
}

}  // namespace hdrcam
