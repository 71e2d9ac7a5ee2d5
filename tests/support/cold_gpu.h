// The graphics device of the tests as a first run meets it: Mesa's cache of compiled kernels, which would
// hide how long they take, is off while one of these lives. Thread-bound; one at a time. Include before
// Catch2.
#pragma once

#include <stdlib.h>

#include <ctime>

#include "tests/support/gpu.h"

namespace hdrcam::test {

class ColdGpu {
 public:
  ColdGpu() {
    ::setenv(kNoCache, "true", 1);
    gpu = open_test_gpu();
    opened_ = std::clock();
  }
  ~ColdGpu() { ::unsetenv(kNoCache); }
  ColdGpu(const ColdGpu&) = delete;
  ColdGpu& operator=(const ColdGpu&) = delete;

  // Of processor time, of all threads, since the device is open.
  double seconds() const { return static_cast<double>(std::clock() - opened_) / CLOCKS_PER_SEC; }

  std::unique_ptr<GpuDevice> gpu;  // null where there is none

 private:
  static constexpr const char* kNoCache = "MESA_SHADER_CACHE_DISABLE";
  std::clock_t opened_;
};

}  // namespace hdrcam::test
