#include "firmware_host/run/pipeline.h"

#include <algorithm>
#include <ctime>
#include <vector>

#include "tests/allocation_checks.h"
#include "tests/contracts/expect.h"
#include "tests/support/moving_scene.h"

namespace hdrcam {
namespace {

// Radiance of each emitted frame, in a row.
std::vector<float> emitted_by(const std::vector<RawFrame>& frames, const CameraFacts& camera, int* kept_out) {
  WorkerPool pool(2);
  Pipeline pipeline(options_of(Preset::Fast, EmitLayer::State), camera, pool);
  std::vector<float> radiance;
  const Pipeline::Deliver deliver = [&](const HdrFrame& frame, const FrameEstimate&,
                                        const FrameRecord&) -> Result<void> {
    const auto samples = frame.radiance.samples();
    radiance.insert(radiance.end(), samples.begin(), samples.end());
    return {};
  };
  for (const RawFrame& frame : frames) require_done(pipeline.take(frame, deliver));
  require_done(pipeline.finish(deliver));
  *kept_out = pipeline.kept_out();
  return radiance;
}

TEST_CASE("a frame whose exposure is not proved changes nothing that is emitted") {
  const test::MovingScene scene;
  std::vector<RawFrame> clean, mixed;
  for (int i = 0; i < 12; ++i) {
    clean.push_back(scene.frame(i)), mixed.push_back(scene.frame(i));
    if (i % 4 != 2) continue;
    RawFrame wrong = scene.frame(i);
    wrong.facts.exposure_s *= 8;
    wrong.facts.flags |= i == 2 ? kFrameExposureUnproved : kFrameDamaged;
    mixed.push_back(std::move(wrong));
  }
  int none = 0, three = 0;
  CHECK(emitted_by(clean, scene.camera(), &none) == emitted_by(mixed, scene.camera(), &three));
  CHECK(none == 0);
  CHECK(three == 3);
}

// Processor time, which other work on the machine does not change.
double cpu_ms() { return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

TEST_CASE("the first HDR frame comes with the sixth frame, after the work of a few frames") {
  constexpr int kBootstrap = 6, kFrames = 24;
  constexpr double kMostFrames = 18;  // of work: three times what was measured (docs/decisions/kernels.md)
  test::MovingScene scene;
  scene.rows = 240, scene.cols = 320;
  WorkerPool pool(1);
  const PipelineOptions options = options_of(Preset::Realtime, EmitLayer::Merged);
  Pipeline pipeline(options, scene.camera(), pool);
  double first_ms = -1, began_ms = 0;
  std::vector<double> steady_ms;
  const Pipeline::Deliver deliver = [&](const HdrFrame&, const FrameEstimate&,
                                        const FrameRecord&) -> Result<void> {
    if (first_ms < 0) first_ms = cpu_ms() - began_ms;
    return {};
  };
  for (int i = 0; i < kFrames; ++i) {
    const RawFrame frame = scene.frame(i);
    CHECK((first_ms >= 0) == (i >= kBootstrap));
    began_ms = cpu_ms();
    require_done(pipeline.take(frame, deliver));
    if (i >= 2 * kBootstrap) steady_ms.push_back(cpu_ms() - began_ms);
  }
  std::ranges::sort(steady_ms);
  INFO("first " << first_ms << " ms, steady " << steady_ms[steady_ms.size() / 2] << " ms");
  CHECK(first_ms < kMostFrames * steady_ms[steady_ms.size() / 2]);
}

TEST_CASE("the fit allocates nothing per frame once it is warm") {
  const test::MovingScene scene;
  for (const EmitLayer layer : {EmitLayer::State, EmitLayer::Merged}) {
    WorkerPool pool(2);
    PipelineOptions options = options_of(Preset::Fast, layer);
    Pipeline pipeline(options, scene.camera(), pool);
    const Pipeline::Deliver ignore = [](const HdrFrame&, const FrameEstimate&,
                                        const FrameRecord&) -> Result<void> { return {}; };
    constexpr int kWarm = 60, kCounted = 60;
    std::vector<RawFrame> frames;
    for (int i = 0; i < kWarm + kCounted; ++i) frames.push_back(scene.frame(i));
    for (int i = 0; i < kWarm; ++i) require_done(pipeline.take(frames[static_cast<std::size_t>(i)], ignore));
    const std::uint64_t before = own_allocations_so_far();
    for (int i = kWarm; i < kWarm + kCounted; ++i)
      require_done(pipeline.take(frames[static_cast<std::size_t>(i)], ignore));
    CHECK_ALLOCATIONS(own_allocations_so_far() - before == 0);
  }
}

}  // namespace
}  // namespace hdrcam
