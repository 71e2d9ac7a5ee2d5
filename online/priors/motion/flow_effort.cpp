#include "online/priors/motion/flow_effort.h"

#include <algorithm>

namespace hdrcam {

FlowEffort effort_of(FlowQuality quality) {
  switch (quality) {
    case FlowQuality::Coarse:
      return {2, 4, 2, 2, 3};
    case FlowQuality::Fast:
      return {1, 4, 2, 2, 3};
    case FlowQuality::Medium:
      return {0, 4, 3, 2, 3};
    case FlowQuality::Fine:
      break;
  }
  return {0, 4, 4, 5, 5};
}

FlowScales scales_of(const FlowEffort& effort, int rows, int cols) {
  constexpr int kLeast = 14, kMostFar = 85;  // pixels of the shorter side
  const int shorter = std::min(rows, cols);
  FlowScales scales{};
  while (shorter >> (scales.coarsest + 1) >= kLeast) ++scales.coarsest;
  while (shorter >> scales.far > kMostFar) ++scales.far;
  scales.finest = std::min(effort.finest_scale, scales.coarsest);
  scales.far = std::max(scales.far, effort.finest_scale);
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
