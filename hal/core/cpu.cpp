#include "hal/core/cpu.h"

#include <cstdlib>
#include <string_view>

#if defined(__x86_64__)
#include <pmmintrin.h>
#include <xmmintrin.h>
#endif

namespace hdrcam {
namespace {

InstructionSet detect() {
  InstructionSet best = InstructionSet::Baseline;
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2"))
    best = InstructionSet::Avx2;
  if (best == InstructionSet::Avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
      __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512cd"))
    best = InstructionSet::Avx512;
#endif
  const char* limit = std::getenv("HDRCAM_ISA");
  if (limit == nullptr) return best;
  if (std::string_view(limit) == "baseline") return InstructionSet::Baseline;
  if (std::string_view(limit) == "avx2" && best == InstructionSet::Avx512) return InstructionSet::Avx2;
  return best;
}

}  // namespace

InstructionSet instruction_set() {
  static const InstructionSet kBest = detect();
  return kBest;
}

const char* name(InstructionSet isa) {
  switch (isa) {
    case InstructionSet::Avx512: return "avx512";
    case InstructionSet::Avx2: return "avx2";
    case InstructionSet::Baseline: break;
  }
  return "baseline";
}

void flush_denormals() {
#if defined(__x86_64__)
  _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
  _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
#endif
}

}  // namespace hdrcam
