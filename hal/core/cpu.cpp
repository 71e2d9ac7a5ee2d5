#include "hal/core/cpu.h"

#include <sys/utsname.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include "hal/core/split_text.h"

#if defined(__x86_64__)
#include <cpuid.h>
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
  if (best == InstructionSet::Avx2 && __builtin_cpu_supports("avx512f") &&
      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512cd"))
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
    case InstructionSet::Avx512:
      return "avx512";
    case InstructionSet::Avx2:
      return "avx2";
    case InstructionSet::Baseline:
      break;
  }
  return "baseline";
}

std::optional<std::string> misnamed_instruction_set() {
  const char* const word = std::getenv("HDRCAM_ISA");
  if (word == nullptr || *word == '\0') return std::nullopt;
  for (const InstructionSet isa : {InstructionSet::Baseline, InstructionSet::Avx2, InstructionSet::Avx512})
    if (std::string_view(word) == name(isa)) return std::nullopt;
  return word;
}

std::string cpu_model() {
#if defined(__x86_64__)
  constexpr unsigned kFirstLeaf = 0x80000002, kLeaves = 3;  // 16 characters each
  std::array<unsigned, 4 * kLeaves> brand{};
  bool told = true;
  for (unsigned i = 0; i < kLeaves; ++i)
    told = told && __get_cpuid(kFirstLeaf + i, &brand[4 * i], &brand[4 * i + 1], &brand[4 * i + 2],
                               &brand[4 * i + 3]);
  std::string text(sizeof brand, '\0');
  std::memcpy(text.data(), brand.data(), sizeof brand);
  text.resize(std::strlen(text.c_str()));
  if (const std::string_view model = trimmed(text); told && !model.empty()) return std::string(model);
#endif
  utsname system{};
  return uname(&system) == 0 ? system.machine : "unknown processor";
}

void flush_denormals() {
#if defined(__x86_64__)
  _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
  _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
#elif defined(__aarch64__)
  constexpr unsigned long kFlushToZero = 1ul << 24;  // FPCR.FZ: of what is read and of what is written
  unsigned long control;
  asm volatile("mrs %0, fpcr" : "=r"(control));
  asm volatile("msr fpcr, %0" : : "r"(control | kFlushToZero));
#endif
}

}  // namespace hdrcam
