// Compiled once per instruction set into namespace HDRCAM_TARGET (see hdrcam_kernels() in CMakeLists.txt).
#include "firmware_host/bench/ceiling_kernels.h"

namespace hdrcam::HDRCAM_TARGET {
namespace {

#if defined(__AVX512F__)
constexpr int kLanes = 16;
#elif defined(__AVX__)
constexpr int kLanes = 8;
#else
constexpr int kLanes = 4;
#endif
typedef float Lanes __attribute__((vector_size(kLanes * sizeof(float))));
constexpr int kChains = 10;  // independent sums: enough to hide the latency of two units

float multiply_add(int rounds) {
  Lanes sum[kChains];
  for (int k = 0; k < kChains; ++k) sum[k] = Lanes{} + static_cast<float>(k);
  Lanes factor = Lanes{} + 0.999f, term = Lanes{} + 1e-3f;
  for (int r = 0; r < rounds; ++r) {
    asm volatile("" : "+x"(factor), "+x"(term));  // not known, so that nothing is folded
    for (int k = 0; k < kChains; ++k) sum[k] = sum[k] * factor + term;
  }
  Lanes all{};
  for (int k = 0; k < kChains; ++k) all += sum[k];
  float total = 0;
  for (int l = 0; l < kLanes; ++l) total += all[l];
  return total;
}

void stream(const float* __restrict a, const float* __restrict b, float* __restrict out, int n) {
  for (int i = 0; i < n; ++i) out[i] = a[i] + 0.5f * b[i];
}

typedef float Pair __attribute__((vector_size(8), aligned(4), may_alias));

float look_up(const float* table, const int* place, int n) {
  Pair sum[8] = {};
  for (int i = 0; i < n; i += 8)
    for (int k = 0; k < 8; ++k) sum[k] += *reinterpret_cast<const Pair*>(table + 2 * place[i + k]);
  float total = 0;
  for (const Pair& s : sum) total += s[0] + s[1];
  return total;
}

}  // namespace

extern const CeilingKernels kCeilingKernels;
const CeilingKernels kCeilingKernels = {multiply_add, 2 * kLanes* kChains, stream, look_up};

}  // namespace hdrcam::HDRCAM_TARGET
