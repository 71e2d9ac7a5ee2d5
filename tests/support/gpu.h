// The graphics device of the tests: the one that HDRCAM_TEST_GPU names, else the best there is, which on a
// build machine is Mesa's software one (./run installs it). Without any, a test says so and ends: under the
// sanitizers, which load no driver. Where HDRCAM_REQUIRE_GPU is set, as by `./run test`, it fails. Include
// before Catch2.
#pragma once

#include <cstdlib>
#include <memory>

#include "hal/gpu/gpu_device.h"
#include "tests/support/not_tested.h"

namespace hdrcam::test {

inline GpuOptions gpu_options() {
  const char* name = std::getenv("HDRCAM_TEST_GPU");
  return {.name = name != nullptr ? name : ""};
}

// Null where there is none.
inline std::unique_ptr<GpuDevice> open_test_gpu(GpuOptions options = gpu_options()) {
  auto gpu = open_gpu(options);
  return gpu ? std::move(*gpu) : nullptr;
}

inline bool gpu_is_required() { return std::getenv("HDRCAM_REQUIRE_GPU") != nullptr; }

}  // namespace hdrcam::test

#define LACKS_GPU(reason)                                              \
  if (hdrcam::test::gpu_is_required()) FAIL("not tested: " << reason); \
  NOT_TESTED(reason)

#define NEEDS_GPU(gpu)                                                         \
  if ((gpu) == nullptr) {                                                      \
    LACKS_GPU("no graphics device here; install mesa-vulkan-drivers for one"); \
    return;                                                                    \
  }
