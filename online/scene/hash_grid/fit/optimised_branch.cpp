#include "online/scene/hash_grid/fit/optimised_branch.h"

namespace hdrcam {

OptimisedBranch::OptimisedBranch(Branch<float>& b)
    : branch(b), network(b.mlp.parameters().size()), d_network(b.mlp.parameters().size(), 0) {
  branch.grid.reserve_gradient();
  const Image<float>& tables = branch.grid.tables();
  table_mean = Image<float>(tables.channels(), 1, tables.cols());
  table_variance = Image<float>(tables.channels(), 1, tables.cols());
  keep();
}

void OptimisedBranch::keep() {
  kept_tables.copy_from(branch.grid.tables());
  kept_network.assign(branch.mlp.parameters().begin(), branch.mlp.parameters().end());
}

void OptimisedBranch::restore() {
  branch.grid.tables().copy_from(kept_tables);
  std::copy(kept_network.begin(), kept_network.end(), branch.mlp.parameters().begin());
  network.forget();
  table_mean.fill(0);
  table_variance.fill(0);
}

}  // namespace hdrcam
