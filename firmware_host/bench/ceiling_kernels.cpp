// Compiled once per instruction set into namespace HDRCAM_TARGET (see hdrcam_kernels() in CMakeLists.txt).
#include "firmware_host/bench/ceiling_kernels.h"

#include "hal/core/register_lanes.h"

namespace hdrcam::HDRCAM_TARGET {
namespace {

constexpr int kChains = 10;  // independent sums: enough to hide the latency of two units

float multiply_add(int rounds) {
  Lanes chain[kChains];
  for (int k = 0; k < kChains; ++k) chain[k] = splat(static_cast<float>(k));
  Lanes factor = splat(0.999f), term = splat(1e-3f);
  for (int r = 0; r < rounds; ++r) {
    asm volatile("" : "+x"(factor), "+x"(term));  // not known, so that nothing is folded
    for (int k = 0; k < kChains; ++k) chain[k] = chain[k] * factor + term;
  }
  Lanes all{};
  for (int k = 0; k < kChains; ++k) all += chain[k];
  return sum(all);
}

void stream(const float* __restrict a, const float* __restrict b, float* __restrict out, int n) {
  for (int i = 0; i < n; ++i) out[i] = a[i] + 0.5f * b[i];
}

float look_up(const float* table, const int* place, int n) {
  Pair part[8] = {};
  for (int i = 0; i < n; i += 8)
    for (int k = 0; k < 8; ++k) part[k] += load_pair(table + 2 * place[i + k]);
  float total = 0;
  for (const Pair& p : part) total += p[0] + p[1];
  return total;
}

}  // namespace

extern const CeilingKernels kCeilingKernels;
const CeilingKernels kCeilingKernels = {multiply_add, 2 * kLanes* kChains, stream, look_up};

}  // namespace hdrcam::HDRCAM_TARGET
