// Clips that break estimators: nothing that leaves may be NaN, infinite or negative, whatever comes in.
#include <cmath>
#include <functional>

#include "firmware_host/run/pipeline.h"
#include "tests/support/moving_scene.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

// Runs the whole pipeline, field included, on what `change` makes of each frame.
void survives(const test::MovingScene& scene, int frames, const std::function<bool(RawFrame&, int)>& change) {
  WorkerPool pool(2);
  PipelineOptions options = options_of(Preset::Fast, EmitLayer::Merged);
  options.knobs.budget.fit.steps = 2;
  Pipeline pipeline(options, scene.camera(), pool);
  int emitted = 0, taken = 0;
  const Pipeline::Deliver deliver = [&](const HdrFrame& frame, const FrameEstimate&,
                                        const FrameRecord&) -> Result<void> {
    ++emitted;
    for (const float l : frame.radiance.samples()) REQUIRE((std::isfinite(l) && l >= 0));
    for (const float s : frame.sigma.samples()) REQUIRE(std::isfinite(s));
    for (const float d : frame.depth.samples()) REQUIRE(std::isfinite(d));
    for (const float v : frame.flow.samples()) REQUIRE(std::isfinite(v));
    return {};
  };
  for (int i = 0; i < frames; ++i) {
    RawFrame raw = scene.frame(i);
    if (!change(raw, i)) continue;
    REQUIRE(pipeline.take(raw, deliver).ok());
    ++taken;
  }
  REQUIRE(pipeline.finish(deliver).ok());
  CHECK(emitted == taken);
}

}  // namespace

TEST_CASE("all black") {
  survives({}, 9, [](RawFrame& raw, int) { return raw.codes.fill(0), true; });
}

TEST_CASE("all saturated") {
  survives({}, 9, [](RawFrame& raw, int) { return raw.codes.fill(255), true; });
}

TEST_CASE("one constant colour") {
  survives({}, 9, [](RawFrame& raw, int) { return raw.codes.fill(100), true; });
}

TEST_CASE("one exposure only") {
  test::MovingScene scene;
  scene.exposures_s = {0.004};
  survives(scene, 9, [](RawFrame&, int) { return true; });
}

TEST_CASE("steps of ten stops") {
  test::MovingScene scene;
  scene.exposures_s = {0.00002, 0.02048};
  survives(scene, 10, [](RawFrame&, int) { return true; });
}

TEST_CASE("a new exposure in every frame") {
  test::MovingScene scene;
  scene.exposures_s.clear();
  for (int i = 0; i < 40; ++i) scene.exposures_s.push_back(0.001 * std::exp2(4 * std::sin(i * 1.7)));
  survives(scene, 40, [](RawFrame&, int) { return true; });
}

TEST_CASE("one moving pixel") {
  survives({}, 9, [](RawFrame& raw, int i) {
    raw.codes.fill(20);
    for (int c = 0; c < 3; ++c) raw.codes.at(c, 24, 3 + 5 * i) = 250;
    return true;
  });
}

TEST_CASE("half of the frames are missing") {
  survives({}, 24, [](RawFrame&, int i) { return (i * 2654435761u >> 16 & 1) == 0; });
}

TEST_CASE("timestamps that stand still or run backwards") {
  survives({}, 9, [](RawFrame& raw, int i) {
    raw.facts.timestamp = Instant::from_seconds(i % 3 == 0 ? 1.0 : 0.5);
    return true;
  });
}

TEST_CASE("a scene cut in every third frame") {
  survives({}, 12, [](RawFrame& raw, int i) {
    if (i / 3 % 2 == 1)
      for (auto& code : raw.codes.samples()) code = static_cast<std::uint16_t>(255 - code);
    return true;
  });
}

TEST_CASE("exposures that are wrong by one frame") {
  const test::MovingScene scene;
  survives(scene, 12, [&](RawFrame& raw, int i) {
    raw.facts.exposure_s = scene.exposures_s[static_cast<std::size_t>(i + 1) % 3];
    return true;
  });
}

TEST_CASE("pictures of a few pixels") {
  for (const auto& [rows, cols] : {std::pair{1, 1}, {1, 9}, {3, 2}, {7, 8}, {17, 16}}) {
    test::MovingScene scene;
    scene.rows = rows, scene.cols = cols;
    INFO(rows << " x " << cols);
    survives(scene, 8, [](RawFrame&, int) { return true; });
  }
}

TEST_CASE("random codes: no frame has to do with the one before") {
  survives({}, 9, [](RawFrame& raw, int i) {
    std::uint32_t state = static_cast<std::uint32_t>(i) + 1;
    for (auto& code : raw.codes.samples())
      state = state * 1664525u + 1013904223u, code = static_cast<std::uint16_t>(state >> 24);
    return true;
  });
}

TEST_CASE("2000 frames of a still scene do not drift") {
  test::MovingScene scene;
  scene.rows = 16, scene.cols = 16;
  scene.drift_px = scene.disc_px = 0;
  WorkerPool pool(1);
  PipelineOptions options = options_of(Preset::Fast, EmitLayer::State);
  Pipeline pipeline(options, scene.camera(), pool);
  double early = 0, late = 0;
  int emitted = 0;
  const Pipeline::Deliver deliver = [&](const HdrFrame& frame, const FrameEstimate&,
                                        const FrameRecord&) -> Result<void> {
    double sum = 0;
    for (const float l : frame.radiance.samples()) sum += std::log(static_cast<double>(l) + 1e-4);
    (emitted < 200 ? early : late) += emitted < 200 ? sum / 200 : emitted >= 1800 ? sum / 200 : 0;
    ++emitted;
    return {};
  };
  std::vector<RawFrame> cycle;
  for (int i = 0; i < 30; ++i) cycle.push_back(scene.frame(i));
  for (int i = 0; i < 2000; ++i) {
    RawFrame& raw = cycle[static_cast<std::size_t>(i % 30)];
    raw.facts.sequence = static_cast<std::uint64_t>(i);
    raw.facts.timestamp = Instant::from_seconds(i / 30.);
    REQUIRE(pipeline.take(raw, deliver).ok());
  }
  REQUIRE(pipeline.finish(deliver).ok());
  CHECK(late / early == Approx(1).margin(0.01));
}
