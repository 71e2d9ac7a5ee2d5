#include "online/scene/hash_grid/fit/vulkan/gpu_branch.h"

#include "online/scene/hash_grid/field/vulkan/branch_layout.h"

namespace hdrcam {
namespace {

constexpr std::size_t kBytes = sizeof(float);

}  // namespace

int GpuBranch::per_chunk(int samples) {
  return std::max(kLeastChunk, (samples + kMostChunks - 1) / kMostChunks);
}

Result<GpuBranch> GpuBranch::make(GpuDevice& device, const Branch<float>& branch, int plane_of_raw) {
  const Mlp<float>& mlp = branch.mlp;
  TRY(check_fits_kernels(mlp));
  GpuBranch made;
  made.levels = branch.grid.shape().levels, made.slots = branch.grid.shape().slots;
  made.entries = static_cast<int>(branch.grid.level(0).entries);
  made.inputs = mlp.inputs(), made.hidden = mlp.hidden(), made.outputs = mlp.outputs();
  made.parameters = static_cast<int>(mlp.parameters().size());
  made.plane_of_raw = plane_of_raw;
  const std::size_t table_bytes = branch.grid.tables().samples().size_bytes();
  TRY(made.lattice.reserve(device, kMostLevels * kLevelWords * sizeof(std::uint32_t)));
  for (GpuRoom* room : {&made.tables, &made.table_mean, &made.table_variance})
    TRY(room->reserve(device, table_bytes));
  TRY(made.d_tables.reserve(device, 2 * table_bytes));
  TRY(made.network.reserve(device,
                           branch_constants::kMostParameters * kBytes));  // as much as the kernels may see
  for (GpuRoom* room : {&made.network_mean, &made.network_variance, &made.d_network})
    TRY(room->reserve(device, mlp.parameters().size_bytes()));
  TRY(made.peaks.reserve(device, kMostLevels * sizeof(std::uint32_t)));
  TRY(made.sums.reserve(device, kMostChunks * mlp.parameters().size_bytes()));
  TRY(made.energy.reserve(device, static_cast<std::size_t>(made.inputs) * kMostChunks * kBytes));
  return made;
}

Result<void> GpuBranch::reserve(GpuDevice& device, int ld) {
  const auto rows = [&](int count) {
    return static_cast<std::size_t>(count) * static_cast<std::size_t>(ld) * kBytes;
  };
  TRY(features.reserve(device, rows(inputs)));
  TRY(d_features.reserve(device, rows(inputs)));
  TRY(trace.reserve(device, rows(inputs + 2 * hidden)));
  return d_pre_activation.reserve(device, rows(2 * hidden + outputs));
}

void GpuBranch::upload(GpuWork& work, const OptimisedBranch& from) const {
  const Branch<float>& branch = from.branch;
  work.upload(bytes_of_numbers(words_of(branch.grid)), **lattice);
  work.upload(bytes_of_numbers(branch.grid.tables().samples()), **tables);
  work.upload(bytes_of_numbers(from.table_mean.samples()), **table_mean);
  work.upload(bytes_of_numbers(from.table_variance.samples()), **table_variance);
  work.upload(bytes_of_numbers(tiled(branch.mlp, branch.mlp.parameters())), **network);
  work.upload(bytes_of_numbers(tiled(branch.mlp, from.network.mean)), **network_mean);
  work.upload(bytes_of_numbers(tiled(branch.mlp, from.network.variance)), **network_variance);
  work.clear(**d_tables);
}

void GpuBranch::download(GpuWork& work, OptimisedBranch& to, Arrival& arrival) const {
  const auto fetch_network = [&](const GpuRoom& from, std::vector<float>& values) {
    values.resize(static_cast<std::size_t>(parameters));
    work.download(**from, std::as_writable_bytes(std::span(values)));
  };
  work.download(**tables, std::as_writable_bytes(to.branch.grid.tables().samples()));
  work.download(**table_mean, std::as_writable_bytes(to.table_mean.samples()));
  work.download(**table_variance, std::as_writable_bytes(to.table_variance.samples()));
  fetch_network(network, arrival.network);
  fetch_network(network_mean, arrival.mean);
  fetch_network(network_variance, arrival.variance);
}

void GpuBranch::take(const Arrival& arrival, OptimisedBranch& to) {
  Mlp<float>& mlp = to.branch.mlp;
  untile(mlp, arrival.network, mlp.parameters());
  untile(mlp, arrival.mean, to.network.mean);
  untile(mlp, arrival.variance, to.network.variance);
}

}  // namespace hdrcam
