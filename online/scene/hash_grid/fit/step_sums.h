// What a step makes of its rays, beside the gradient of the networks; wherever it is computed. Value type.
#pragma once

#include <cstddef>
#include <vector>

#include "online/scene/hash_grid/fit/learned_response.h"
#include "online/scene/hash_grid/fit/loss_table.h"

namespace hdrcam {

struct StepSums {
  LossValues<double> losses{};  // weighted, by LossTerm, over all rays
  LearnedResponse<float>::Gradient d_response{};
  double feature_energy = 0;   // as RayShard::feature_energy(), of all
  std::vector<float> misfits;  // photometric, by ray

  // To zero, for a step of so many rays.
  void begin(std::size_t rays) {
    losses.fill(0);
    for (auto& channel : d_response) channel.fill(0);
    feature_energy = 0;
    misfits.resize(rays);
  }
  // Adds the losses of a shard, one after the other in their order; d_shard: of the response, or null.
  void add(const LossValues<float>& shard, const LearnedResponse<float>::Gradient* d_shard) {
    for (std::size_t i = 0; i < losses.size(); ++i) losses[i] += static_cast<double>(shard[i]);
    if (d_shard == nullptr) return;
    for (std::size_t c = 0; c < d_response.size(); ++c)
      for (std::size_t j = 0; j < d_response[c].size(); ++j) d_response[c][j] += (*d_shard)[c][j];
  }
};

}  // namespace hdrcam
