// The dense flow on the graphics device against the processor's, and what happens when the device fails. Its
// passes: flow_passes_test.cpp.
#include "online/priors/motion/vulkan/vulkan_flow.h"

#include <cmath>
#include <random>

#include "hal/fault/faulty_gpu.h"
#include "online/pictures/between_pixels.h"
#include "tests/support/cold_gpu.h"

#include "tests/support/checked_gpu.h"

using namespace hdrcam;

namespace {

constexpr int kRows = 123, kCols = 162;  // an odd size at some scales, and no multiple of a patch

// Waves of random direction and length.
Image<float> texture(unsigned seed, int rows, int cols) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> share(0, 1);
  Image<float> codes(1, rows, cols);
  codes.fill(128);
  for (int wave = 0; wave < 10; ++wave) {
    const float angle = 6.2832f * share(random), length = 6 + 34 * share(random);
    const float u = 6.2832f / length * std::cos(angle), v = 6.2832f / length * std::sin(angle);
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < cols; ++x)
        codes.at(0, y, x) += 12 * std::sin(u * static_cast<float>(x) + v * static_cast<float>(y));
  }
  return codes;
}

// Two pictures between which the ground drifts and turns a little and a box of its own texture moves by
// `jump` pixels to the right.
struct Scene {
  Image<float> a, b;

  explicit Scene(int jump = 9, int rows = kRows, int cols = kCols) : a(1, rows, cols), b(1, rows, cols) {
    const Image<float> ground = texture(4, rows + 40, cols + 40), box = texture(7, rows, cols);
    const int size = rows / 3, left = cols / 4, top = rows / 3;
    const auto see = [&](Image<float>& picture, float drift, int moved) {
      for (int y = 0; y < rows; ++y)
        for (int x = 0; x < cols; ++x) {
          const bool hit = x >= left + moved && x < left + moved + size && y >= top && y < top + size;
          const float turn = 0.01f * drift * static_cast<float>(y - rows / 2);
          const BetweenPixels place(rows + 40, cols + 40, x + 20, y + 20, {drift + turn, -0.6f * drift});
          picture.at(0, y, x) = hit ? box.at(0, y, x - moved) : place.of(ground, 0);
        }
    };
    see(a, 0, 0), see(b, 2.3f, jump);
  }
};

struct Flows {
  Image<float> there, back;

  Flows(DenseFlow& flow, const Scene& scene, FlowQuality quality, const Image<float>* guess = nullptr) {
    FlowRequest request{&scene.a, &scene.b, &there, &back};
    if (guess != nullptr) request.start_a_to_b = {guess, 0.8f, true}, request.start_b_to_a = {guess, -0.8f};
    flow.compute(quality, request);
  }
};

// Pixels whose vectors are less than a hundredth of a pixel apart: where two guesses are equally good by the
// last bit, a patch may take either.
double share_alike(const Image<float>& there, const Image<float>& here) {
  REQUIRE(there.same_shape(here));
  std::size_t alike = 0;
  for (std::size_t i = 0; i < here.plane_size(); ++i) {
    REQUIRE(std::isfinite(there.samples()[i]));
    const float du = there.plane(0)[i] - here.plane(0)[i], dv = there.plane(1)[i] - here.plane(1)[i];
    alike += std::hypot(du, dv) < 0.01f ? 1 : 0;
  }
  return static_cast<double>(alike) / static_cast<double>(here.plane_size());
}
void check_alike(const Flows& there, const Flows& here) {
  CHECK(share_alike(there.there, here.there) > 0.98);
  CHECK(share_alike(there.back, here.back) > 0.98);
}
void check_same(const Flows& a, const Flows& b) {
  CHECK(std::ranges::equal(a.there.samples(), b.there.samples()));
  CHECK(std::ranges::equal(a.back.samples(), b.back.samples()));
}

constexpr std::array kQualities{FlowQuality::Coarse, FlowQuality::Fast, FlowQuality::Medium,
                                FlowQuality::Fine};

}  // namespace

TEST_CASE("a flow on the graphics device is the processor's, at every quality", "[gpu]") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  WorkerPool pool(1);
  VulkanFlow there(kRows, kCols, pool, *gpu);
  CpuFlow here(pool);
  for (const FlowQuality quality : kQualities) {
    INFO("quality " << static_cast<int>(quality));
    const Scene scene;
    check_alike(Flows(there, scene, quality), Flows(here, scene, quality));
  }
  CHECK(there.fallback_reason().empty());
}

TEST_CASE("small pictures have the processor's flow on the graphics device, and the smallest none", "[gpu]") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  WorkerPool pool(1);
  for (const auto& [rows, cols] : {std::pair{15, 40}, {16, 16}, {17, 40}, {64, 90}}) {
    CAPTURE(rows, cols);
    const Scene tiny(2, rows, cols);
    VulkanFlow there(rows, cols, pool, *gpu);
    CpuFlow here(pool);
    check_alike(Flows(there, tiny, FlowQuality::Fine), Flows(here, tiny, FlowQuality::Fine));
    CHECK(there.fallback_reason().empty());
  }
}

TEST_CASE("a flow on the graphics device starts where it is told to, in each direction", "[gpu]") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  WorkerPool pool(1);
  VulkanFlow there(kRows, kCols, pool, *gpu);
  CpuFlow here(pool);
  // stripes, between whose shifts nothing but the start decides
  Scene scene;
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kCols; ++x) {
      scene.a.at(0, y, x) = 128 + 90 * std::sin(6.2831853f * static_cast<float>(x) / 12);
      scene.b.at(0, y, x) = 128 + 90 * std::sin(6.2831853f * static_cast<float>(x - 3) / 12);
    }
  Image<float> guess(2, kRows, kCols);
  std::fill_n(guess.plane(0), guess.plane_size(), 15 / 0.8f);
  const Flows found(there, scene, FlowQuality::Medium, &guess);
  CHECK(found.there.at(0, kRows / 2, kCols / 2) == Approx(15).margin(0.5));
  CHECK(found.back.at(0, kRows / 2, kCols / 2) == Approx(-15).margin(0.5));
  check_alike(found, Flows(here, scene, FlowQuality::Medium, &guess));
  // clipped, a guess could not be refuted
  scene.a.fill(255), scene.b.fill(255);
  check_alike(Flows(there, scene, FlowQuality::Medium, &guess),
              Flows(here, scene, FlowQuality::Medium, &guess));
  CHECK(there.fallback_reason().empty());
}

TEST_CASE("an object that moves farther than its own size is found on the graphics device, too", "[gpu]") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  WorkerPool pool(1);
  constexpr int kJump = 84, kTall = 240, kWide = 320;
  const Scene scene(kJump, kTall, kWide);
  VulkanFlow there(kTall, kWide, pool, *gpu);
  const Flows found(there, scene, FlowQuality::Medium);
  const int x = kWide / 4 + kTall / 6, y = kTall / 3 + kTall / 6;  // the middle of the box
  CHECK(found.there.at(0, y, x) == Approx(kJump).margin(0.5));
  CHECK(found.back.at(0, y, x + kJump) == Approx(-kJump).margin(0.5));
  CpuFlow here(pool);
  check_alike(found, Flows(here, scene, FlowQuality::Medium));
  CHECK(there.fallback_reason().empty());
}

TEST_CASE("the same graphics device finds the same flow again, for any number of threads", "[gpu]") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  WorkerPool one(1), three(3);
  const Scene scene;
  VulkanFlow first(kRows, kCols, one, *gpu), second(kRows, kCols, three, *gpu);
  check_same(Flows(first, scene, FlowQuality::Medium), Flows(second, scene, FlowQuality::Medium));
  CHECK(first.fallback_reason().empty());
  CHECK(second.fallback_reason().empty());
}

TEST_CASE("a graphics device that fails leaves the flow to the processor, to the same bytes", "[gpu]") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  WorkerPool pool(1);
  const Scene scene;
  CpuFlow here(pool);
  const Flows expected(here, scene, FlowQuality::Medium);
  const auto check = [&](const GpuFaults& faults, const char* reason) {
    FaultyGpu faulty(*gpu, faults);
    VulkanFlow there(kRows, kCols, pool, faulty);
    check_same(Flows(there, scene, FlowQuality::Medium), expected);
    CHECK(there.fallback_reason().find(reason) != std::string::npos);
    check_same(Flows(there, scene, FlowQuality::Medium), expected);
  };
  check({.buffers_until_full = 0}, "full");
  check({.buffers_until_full = 7}, "full");
  check({.kernels_until_refused = 3}, "compiler has no memory");
  check({.finishes_until_lost = 0}, "was lost");
  check({.finishes_until_lost = 1}, "was lost");
}

TEST_CASE("the checks of Vulkan find nothing wrong with the flow's passes", "[gpu]") {
  test::CheckedGpu checked;
  if (checked.gpu == nullptr) return;
  {
    WorkerPool pool(1);
    VulkanFlow there(kRows, kCols, pool, *checked.gpu);
    const Scene scene(60);
    Image<float> guess(2, kRows, kCols);
    const Flows fast(there, scene, FlowQuality::Fast), guided(there, scene, FlowQuality::Medium, &guess);
    CHECK(there.fallback_reason().empty());
  }
  checked.expect_no_complaints();
}

TEST_CASE("the flow's kernels are compiled and have run once within three seconds of processor time",
          "[gpu]") {
  const test::ColdGpu cold;
  NEEDS_GPU(cold.gpu);
  WorkerPool pool(1);
  VulkanFlow there(64, 90, pool, *cold.gpu);
  const Flows found(there, Scene(9, 64, 90), FlowQuality::Fast);
  CHECK(there.fallback_reason().empty());
  CHECK(cold.seconds() < 3);
}
