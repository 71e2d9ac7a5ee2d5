// The capabilities of this processor. pick_kernels() selects a kernel that exists once per instruction set;
// HDRCAM_ISA=baseline|avx2 lowers the choice to compare or to reproduce another machine's bytes.
#pragma once

#include <optional>
#include <string>

namespace hdrcam {

enum class InstructionSet { Baseline, Avx2, Avx512 };

// The best set that both this processor and the environment variable HDRCAM_ISA allow. Thread-safe.
InstructionSet instruction_set();
const char* name(InstructionSet isa);

// What HDRCAM_ISA says, if it names no instruction set and so has no effect. Thread-safe.
std::optional<std::string> misnamed_instruction_set();

// The vendor's name of this processor, or its architecture where it reports none.
std::string cpu_model();

// Flushes denormals to zero on the calling thread: a field that decays towards zero must not become slow.
void flush_denormals();

// Binds a table of function pointers, one table per instruction set, to this processor.
template <class Table>
const Table& pick_kernels([[maybe_unused]] const Table& baseline, [[maybe_unused]] const Table& avx2,
                          [[maybe_unused]] const Table& avx512) {
  switch (instruction_set()) {
    case InstructionSet::Avx512:
      return avx512;
    case InstructionSet::Avx2:
      return avx2;
    case InstructionSet::Baseline:
      break;
  }
  return baseline;
}

}  // namespace hdrcam
