// What a step makes of its rays, beside the gradient of the networks; wherever it is computed. Value type.
#pragma once

#include <vector>

#include "online/scene/hash_grid/fit/learned_response.h"
#include "online/scene/hash_grid/fit/loss_table.h"

namespace hdrcam {

struct StepSums {
  LossValues<double> losses{};  // weighted, by LossTerm, over all rays
  LearnedResponse<float>::Gradient d_response{};
  double feature_energy = 0;   // as RayShard::feature_energy(), of all
  std::vector<float> misfits;  // photometric, by ray
};

}  // namespace hdrcam
