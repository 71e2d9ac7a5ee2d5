// Rates of kernels beside the ceilings of this processor, measured in the same run. Thread-bound.
#pragma once

#include <atomic>
#include <span>
#include <string>
#include <vector>

#include "firmware_host/bench/kernel_tasks.h"
#include "hal/core/result.h"

namespace hdrcam {

enum class KernelBound { Unknown, Arithmetic, Memory, LookUps };
const char* name(KernelBound bound);

struct KernelRate {
  std::string kernel, item;
  double items_per_s = 0;
  double ceiling_per_s = 0;  // 0: none is known
  KernelBound bound = KernelBound::Unknown;
};

struct KernelRates {
  double flops_per_s = 0;     // of multiply-adds in registers
  double look_ups_per_s = 0;  // pairs of floats at places of a table of one hash grid's size
  std::vector<KernelRate> kernels;
};

// seconds: for each kernel; the fastest of several repetitions counts. Errors: Interrupted once `stop` is
// set.
Result<KernelRates> measure_kernels(std::span<const KernelTask> tasks, double seconds,
                                    const std::atomic<bool>& stop);

std::string rates_table(const KernelRates& rates);  // Markdown
std::string rates_json(const KernelRates& rates, int rows, int cols);

}  // namespace hdrcam
