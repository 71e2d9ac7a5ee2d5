// What the graphics device sees of a field against what the processor sees.
#include "online/scene/hash_grid/field/vulkan/vulkan_probe.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "hal/fault/faulty_gpu.h"
#include "online/scene/hash_grid/field/field_renderer.h"
#include "tests/online/scene/hash_grid/field/learned_networks.h"
#include "tests/online/scene/hash_grid/fit/window_fixture.h"
#include "tests/support/cold_gpu.h"

#include "tests/support/checked_gpu.h"

using namespace hdrcam;

namespace {

constexpr int kRows = 24, kCols = 33, kFrames = 3;

// A window with a field that has learned something.
struct Scene {
  WindowFixture fixture{kRows, kCols, kFrames, true};
  FieldNetworks<float> networks;
  int samples = 8;
  bool has_dynamic = true;

  explicit Scene(Blend blend = Blend::DensitySum) : networks(learned_networks(blend, kFrames)) {}
  RadianceField field() const { return {fixture.window, networks, samples, has_dynamic}; }
  // From a place a little beside the frame's.
  ProbeView view(int frame, float offset) const {
    ProbeView view;
    view.T_anchor_camera = fixture.window.frame(frame).T_anchor_camera;
    view.T_anchor_camera.t += Eigen::Vector3d(0.03, -0.02, 0.01);
    view.frame = frame, view.offset = offset;
    return view;
  }
  std::vector<ProbeRay> rays() const {
    std::vector<ProbeRay> rays;
    for (int y = -2; y < kRows + 2; y += 2)  // some look past the picture
      for (int x = -2; x < kCols + 2; ++x)
        rays.push_back({{static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f},
                        0.05f + 0.02f * static_cast<float>((x * 7 + y * 3 + 99) % 40)});
    return rays;
  }
};

std::vector<ProbeAnswer> seen_here(const RadianceField& field, const ProbeView& view,
                                   std::span<const ProbeRay> rays) {
  FieldProbe probe(field.networks, kMaxSamples);
  std::vector<ProbeAnswer> answers(rays.size());
  for (std::size_t first = 0; first < rays.size(); first += FieldProbe::kRays) {
    const std::size_t n = std::min<std::size_t>(FieldProbe::kRays, rays.size() - first);
    probe.look(field, view, rays.subspan(first, n), std::span(answers).subspan(first, n));
  }
  return answers;
}

// A thousandth of what is there, beyond the sizes below which it does not matter.
void check_alike(std::span<const ProbeAnswer> there, std::span<const ProbeAnswer> here) {
  const auto alike = [](float a, float b, float floor) {
    return std::isfinite(a) && std::abs(a - b) <= 1e-3f * (floor + std::abs(b));
  };
  std::size_t apart = 0;
  for (std::size_t r = 0; r < here.size(); ++r) {
    const ProbeAnswer &a = there[r], &b = here[r];
    bool same = alike(a.inverse_depth, b.inverse_depth, 0.1f) && alike(a.confidence, b.confidence, 1);
    for (int c = 0; c < 3; ++c) same = same && alike(a.radiance[c], b.radiance[c], 0.01f);
    for (int n = 0; n < 2; ++n)
      for (int d = 0; d < 2; ++d) same = same && alike(a.flow[n][d], b.flow[n][d], 1);
    apart += same ? 0 : 1;
  }
  INFO(apart << " of " << here.size() << " rays");
  CHECK(apart == 0);
}

}  // namespace

TEST_CASE("the graphics device sees of a field what the processor sees", "[gpu]") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  const auto probe = value_of(VulkanProbe::make(*gpu));
  for (const Blend blend : {Blend::DensitySum, Blend::Weight})
    for (const int samples : {1, 3, 8, 16})
      for (const bool has_dynamic : {true, false})
        for (const float offset : {0.f, 0.4f, -0.3f}) {
          Scene scene(blend);
          scene.samples = samples, scene.has_dynamic = has_dynamic;
          const int frame = samples % kFrames;
          INFO(samples << " samples, dynamic " << has_dynamic << ", offset " << offset << ", frame "
                       << frame);
          const std::vector<ProbeRay> rays = scene.rays();
          std::vector<ProbeAnswer> answers(rays.size());
          require_done(probe->look(scene.field(), scene.view(frame, offset), rays, answers));
          check_alike(answers, seen_here(scene.field(), scene.view(frame, offset), rays));
        }
}

TEST_CASE("the graphics device sees the same twice, to the last bit, in batches and at once", "[gpu]") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  const auto probe = value_of(VulkanProbe::make(*gpu));
  Scene scene;
  scene.samples = 2;
  std::vector<ProbeRay> rays;
  while (rays.size() < 20000)
    for (const ProbeRay& ray : scene.rays()) rays.push_back(ray);
  std::vector<ProbeAnswer> first(rays.size()), second(rays.size()), few(100);
  require_done(probe->look(scene.field(), scene.view(1, 0.2f), rays, first));
  require_done(probe->look(scene.field(), scene.view(1, 0.2f), rays, second));
  CHECK(std::memcmp(first.data(), second.data(), first.size() * sizeof(ProbeAnswer)) == 0);
  require_done(probe->look(scene.field(), scene.view(1, 0.2f), {rays.data() + 19000, 100}, few));
  CHECK(std::memcmp(first.data() + 19000, few.data(), few.size() * sizeof(ProbeAnswer)) == 0);
}

TEST_CASE("a graphics device that is full or lost leaves views to the processor", "[gpu]") {
  const auto gpu = test::open_test_gpu();
  NEEDS_GPU(gpu);
  Scene scene;
  WorkerPool pool(1);
  SceneView view;
  view.T_world_camera = scene.fixture.window.frame(1).T_world_camera;
  view.time_s = scene.fixture.window.frame(1).time_s;
  view.lens = scene.fixture.window.frustum().camera, view.rows = kRows, view.cols = kCols;
  FieldPicture here;
  FieldRenderer processor;
  processor.render(scene.field(), view, pool, here);
  for (const GpuFaults& faults : {GpuFaults{.buffers_until_full = 3}, GpuFaults{.kernels_until_refused = 1},
                                  GpuFaults{.finishes_until_lost = 0}, GpuFaults{.finishes_until_lost = 1}}) {
    FaultyGpu faulty(*gpu, faults);
    FieldRenderer renderer(&faulty);
    FieldPicture there;
    for (int look = 0; look < 3; ++look) {
      renderer.render(scene.field(), view, pool, there);
      for (std::size_t i = 0; i < here.radiance.size(); ++i)
        REQUIRE(there.radiance.samples()[i] == Approx(here.radiance.samples()[i]).epsilon(1e-3).margin(1e-5));
    }
    CHECK(std::ranges::equal(there.radiance.samples(), here.radiance.samples()));  // all of it by then
  }
}

TEST_CASE("the checks of Vulkan find nothing wrong with views of the field", "[gpu]") {
  test::CheckedGpu checked;
  if (checked.gpu == nullptr) return;
  {
    const auto probe = value_of(VulkanProbe::make(*checked.gpu));
    const Scene scene;
    const std::vector<ProbeRay> rays = scene.rays();
    std::vector<ProbeAnswer> answers(rays.size());
    require_done(probe->look(scene.field(), scene.view(1, 0.2f), rays, answers));
    require_done(probe->look(scene.field(), scene.view(2, 0), rays, answers));
  }
  checked.expect_no_complaints();
}

TEST_CASE("the field's kernels are compiled and have run once within three seconds of processor time",
          "[gpu]") {
  const test::ColdGpu cold;
  NEEDS_GPU(cold.gpu);
  const Scene scene;
  const std::vector<ProbeRay> rays = scene.rays();
  std::vector<ProbeAnswer> answers(rays.size());
  const auto probe = value_of(VulkanProbe::make(*cold.gpu));
  require_done(probe->look(scene.field(), scene.view(1, 0.2f), rays, answers));
  CHECK(cold.seconds() < 3);
}
