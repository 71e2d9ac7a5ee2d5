// The graphics device of the tests under the validation layers. Include last: it brings Catch2.
#pragma once

#include <string>
#include <vector>

#include "tests/support/gpu.h"

#include "tests/contracts/expect.h"

namespace hdrcam::test {

// Without a device or without the layers, `gpu` is null and the test has said so; any other failure to open
// it fails the test.
struct CheckedGpu {
  std::vector<std::string> complaints;  // of the layers
  std::unique_ptr<GpuDevice> gpu;

  CheckedGpu() {
    if (open_test_gpu() == nullptr) {
      LACKS_GPU("no graphics device here");
      return;
    }
    GpuOptions options = gpu_options();
    options.complaints = &complaints;
    auto opened = open_gpu(options);
    if (!opened && opened.error().code == ErrorCode::Unsupported) {
      LACKS_GPU(opened.error().message);
      return;
    }
    REQUIRE(opened.ok());
    gpu = std::move(*opened);
  }
  // Closes the device: a complaint about what it leaves behind counts, too.
  void expect_no_complaints() {
    gpu.reset();
    for (const std::string& complaint : complaints) FAIL_CHECK(complaint);
  }
};

}  // namespace hdrcam::test
