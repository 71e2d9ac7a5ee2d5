// One branch of the field on a graphics device while it is fitted: its parameters with Adam's moments, and
// what a step makes of its samples. Thread-bound like the device, which outlives it.
#pragma once

#include "online/scene/hash_grid/field/vulkan/gpu_room.h"
#include "online/scene/hash_grid/fit/optimised_branch.h"

namespace hdrcam {

struct GpuBranch {
  int levels = 0, slots = 0, entries = 0;                   // of the grid; entries: of a level and slot
  int inputs = 0, hidden = 0, outputs = 0, parameters = 0;  // of the network
  int plane_of_raw = 0;                                     // of its first output in `raw` (gpu_rays.h)
  GpuRoom lattice, tables, table_mean, table_variance;      // lattice: HashLevel
  GpuRoom network, network_mean, network_variance;          // in tiles, as the gradient and the sums
  GpuRoom d_tables;              // in whole numbers (fixed_point.glsl); 0 between steps
  GpuRoom features, d_features;  // [inputs][ld]
  GpuRoom trace, d_pre_activation, sums, d_network, energy, peaks;  // backward.comp, outer.comp, measure.comp

  static constexpr int kMostChunks = 256, kLeastChunk = 64;  // of samples: they are added up chunk by chunk
  static int per_chunk(int samples);
  static int chunks(int samples) { return (samples + per_chunk(samples) - 1) / per_chunk(samples); }

  int level_size() const { return slots * entries; }
  // The slot that the grid's kernels are told: -1, each sample's own.
  int slot() const { return slots == 1 ? 0 : -1; }

  // Room for the parameters. Errors: those of the device; Unsupported for too large a network.
  static Result<GpuBranch> make(GpuDevice& device, const Branch<float>& branch, int plane_of_raw);
  Result<void> reserve(GpuDevice& device, int ld);
  void upload(GpuWork& work, const OptimisedBranch& from) const;

  // The network on its way back, in tiles.
  struct Arrival {
    std::vector<float> network, mean, variance;
  };
  // The tables reach `to` with finish(), the network with take() after it; on an error nothing does.
  void download(GpuWork& work, OptimisedBranch& to, Arrival& arrival) const;
  static void take(const Arrival& arrival, OptimisedBranch& to);
};

}  // namespace hdrcam
