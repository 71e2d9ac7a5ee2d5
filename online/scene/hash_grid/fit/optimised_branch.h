// A branch's parameters as the optimiser sees them: with Adam's moments, the gradient of its network, and the
// last good copy. The branch outlives it. Thread-compatible.
#pragma once

#include <array>

#include "online/scene/hash_grid/field/field.h"
#include "online/scene/hash_grid/fit/adam.h"

namespace hdrcam {

struct OptimisedBranch {
  Branch<float>& branch;
  AdamMoments network;
  Image<float> table_mean, table_variance;  // as the grid's tables
  std::vector<float> d_network;
  Image<float> kept_tables;  // last good copy
  std::vector<float> kept_network;

  explicit OptimisedBranch(Branch<float>& b);
  void keep();
  void restore();
};

// Those of a field, whose networks outlive them.
struct OptimisedBranches {
  OptimisedBranch static_, dynamic;

  explicit OptimisedBranches(FieldNetworks<float>& networks)
      : static_(networks.static_), dynamic(networks.dynamic) {}
  std::array<OptimisedBranch*, 2> both() { return {&static_, &dynamic}; }
};

}  // namespace hdrcam
