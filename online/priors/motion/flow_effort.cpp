#include "online/priors/motion/flow_effort.h"

#include <algorithm>

namespace hdrcam {

FlowEffort effort_of(FlowQuality quality) {
  switch (quality) {
    case FlowQuality::Coarse:
      return {.finest_scale = 2, .stride = 4, .steps = 2, .rounds = 2, .sweeps = 3};
    case FlowQuality::Fast:
      return {.finest_scale = 1, .stride = 4, .steps = 2, .rounds = 2, .sweeps = 3};
    case FlowQuality::Medium:
      return {.finest_scale = 0, .stride = 4, .steps = 3, .rounds = 2, .sweeps = 3};
    case FlowQuality::Fine:
      break;
  }
  return {.finest_scale = 0, .stride = 4, .steps = 4, .rounds = 5, .sweeps = 5};
}

FlowScales scales_of(const FlowEffort& effort, int rows, int cols) {
  constexpr int kLeast = 14, kMostFar = 85;  // pixels of the shorter side
  const int shorter = std::min(rows, cols);
  FlowScales scales{};
  while (shorter >> (scales.coarsest + 1) >= kLeast) ++scales.coarsest;
  while (shorter >> scales.far > kMostFar) ++scales.far;
  scales.finest = std::min(effort.finest_scale, scales.coarsest);
  scales.far = std::max(scales.far, scales.finest);
  return scales;
}

PatchGrid patch_grid(int rows, int cols, int stride) {
  const auto places = [&](int size) { return 1 + (size - kPatchSize + stride - 1) / stride; };
  return {places(rows), places(cols), stride};
}

int far_reach(int side) {
  using namespace flow_constants;
  return std::min(side / kReach, kMostReach);
}

}  // namespace hdrcam
