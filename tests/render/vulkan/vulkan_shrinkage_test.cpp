// Shrinkage on the graphics device against the processor's.
#include "render/vulkan/vulkan_shrinkage.h"

#include <cmath>

#include "hal/fault/faulty_gpu.h"
#include "online/state/radiance_state.h"
#include "render/shrinkage.h"
#include "tests/support/cold_gpu.h"

#include "tests/support/checked_gpu.h"

using namespace hdrcam;

namespace {

constexpr float kOffset = 2e-4f;

struct Noisy {
  Image<float> radiance, variance;

  Noisy(int rows, int cols) : radiance(3, rows, cols), variance(3, rows, cols) {
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < rows; ++y)
        for (int x = 0; x < cols; ++x) {
          const double light = std::exp2(2 * std::sin(0.3 * x + c) * std::cos(0.2 * y) - 1);
          const double grain = std::sin(12.9898 * x + 78.233 * y + 37.7 * c) * 43758.5453;
          radiance.at(c, y, x) = static_cast<float>(light * (1 + 0.1 * (grain - std::floor(grain) - 0.5)));
          variance.at(c, y, x) =
              (x + 2 * y) % 37 == 0 ? kUnseenVariance : static_cast<float>(light * light * 1e-3);
        }
  }
};

void check_alike(const Image<float>& there, const Image<float>& here) {
  for (std::size_t i = 0; i < here.size(); ++i)
    REQUIRE(there.samples()[i] == Approx(here.samples()[i]).epsilon(2e-4).margin(1e-5));
}

}  // namespace

TEST_CASE("shrinkage on the graphics device is the processor's at any size", "[gpu]") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  WorkerPool pool(1);
  Shrinkage there(pool, gpu.get()), here(pool);
  for (const auto& [rows, cols] : {std::pair(8, 8), {9, 15}, {48, 64}, {37, 70}, {38, 44}, {7, 40}}) {
    INFO(cols << "x" << rows);
    const Noisy noisy(rows, cols);
    for (const ShrinkageOptions options :
         {ShrinkageOptions{kOffset, NoiseOrigin::Sensor, ShrinkageEffort::On},
          {kOffset, NoiseOrigin::Unknown, ShrinkageEffort::Dense}}) {
      Image<float> a = noisy.radiance.clone(), b = noisy.radiance.clone();
      there.apply(a, noisy.variance, options);
      here.apply(b, noisy.variance, options);
      check_alike(a, b);
    }
  }
}

TEST_CASE("a graphics device that is full or lost leaves shrinkage to the processor, to the same bytes",
          "[gpu]") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  WorkerPool pool(1);
  const Noisy noisy(30, 41);
  Image<float> expected = noisy.radiance.clone();
  Shrinkage(pool).apply(expected, noisy.variance, {kOffset, NoiseOrigin::Unknown});
  for (const GpuFaults& faults :
       {GpuFaults{.buffers_until_full = 2}, GpuFaults{.kernels_until_refused = 0},
        GpuFaults{.kernels_until_refused = 2}, GpuFaults{.finishes_until_lost = 0}}) {
    FaultyGpu faulty(*gpu, faults);
    Shrinkage there(pool, &faulty);
    for (int frame = 0; frame < 2; ++frame) {
      Image<float> picture = noisy.radiance.clone();
      there.apply(picture, noisy.variance, {kOffset, NoiseOrigin::Unknown});
      CHECK(std::equal(picture.samples().begin(), picture.samples().end(), expected.samples().begin()));
    }
  }
}

TEST_CASE("the checks of Vulkan find nothing wrong with shrinkage", "[gpu]") {
  test::CheckedGpu checked;
  if (checked.gpu == nullptr) return;
  WorkerPool pool(1);
  Noisy noisy(30, 41);
  require_done(value_of(VulkanShrinkage::make(*checked.gpu, pool))
                   ->apply(noisy.radiance, noisy.variance, {kOffset, NoiseOrigin::Unknown}));
  checked.expect_no_complaints();
}

TEST_CASE("shrinkage's kernels are compiled and have run once within three seconds of processor time",
          "[gpu]") {
  const test::ColdGpu cold;
  NEEDS_GPU(cold.gpu);
  WorkerPool pool(1);
  Noisy noisy(30, 41);
  require_done(value_of(VulkanShrinkage::make(*cold.gpu, pool))
                   ->apply(noisy.radiance, noisy.variance, {kOffset, NoiseOrigin::Unknown}));
  CHECK(cold.seconds() < 3);
}
