// How much memory a run may take, and the one sentence for work that needs more: said before anything is
// allocated, as a machine that runs out of memory ends some process without a word. Value type, reentrant.
#pragma once

#include <cstdint>
#include <string>

#include "hal/core/result.h"

namespace hdrcam {

class MemoryLimit {
 public:
  explicit MemoryLimit(std::uint64_t bytes) : bytes_(bytes) {}
  // Half of what this machine has, or of what the control group of this process and those around it may take
  // (a service with MemoryMax, a container). root: where /proc and /sys are found, for tests.
  static MemoryLimit share_of_machine(const std::string& root = "");

  // what: "the fit of pictures of 1920x1080". Errors: Unsupported where it needs more.
  Result<void> admit(const std::string& what, std::uint64_t bytes) const;
  std::uint64_t bytes() const { return bytes_; }

 private:
  std::uint64_t bytes_;
};

}  // namespace hdrcam
