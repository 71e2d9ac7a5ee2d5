// That what is known about the camera's place and the scene's depth reaches the field: a camera that slides
// past a plane whose depth its poses tell.
#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "firmware_host/run/pipeline.h"
#include "tests/support/moving_scene.h"

#include "tests/contracts/expect.h"

namespace hdrcam {
namespace {

constexpr int kFrames = 10;
constexpr double kDepth_m = 2;

test::MovingScene plane() {
  test::MovingScene scene;
  scene.rows = 64, scene.cols = 96;
  scene.drift_px = scene.disc_px = 1.5;  // all of it: nothing moves by itself
  return scene;
}

struct Emitted {
  std::vector<float> radiance, depth;  // of the last frame
  std::set<std::string> losses;        // that weighed in any frame
};

Emitted emitted_by(const test::MovingScene& scene, EmitLayer layer) {
  WorkerPool pool(2);
  PipelineOptions options = options_of(Preset::Fast, layer);
  options.render.depth = DepthLayer::Whole;
  if (layer != EmitLayer::State) options.knobs.budget.fit.steps = options.knobs.view_steps;
  Pipeline pipeline(options, scene.camera(), pool);
  Emitted emitted;
  const Pipeline::Deliver deliver = [&](const HdrFrame& frame, const FrameEstimate&,
                                        const FrameRecord& record) -> Result<void> {
    emitted.radiance.assign(frame.radiance.samples().begin(), frame.radiance.samples().end());
    emitted.depth.assign(frame.depth.samples().begin(), frame.depth.samples().end());
    for (const NamedValue& loss : record.losses) emitted.losses.insert(std::string(loss.name));
    return {};
  };
  // the picture moves to the right, so the camera moves to the left
  const double step_m = -scene.drift_px * kDepth_m / scene.camera().intrinsics->fx_px;
  for (int i = 0; i < kFrames; ++i) {
    RawFrame frame = scene.frame(i);
    frame.facts.T_world_camera = PoseMatrix{1, 0, 0, step_m * i, 0, 1, 0, 0, 0, 0, 1, 0};
    require_done(pipeline.take(frame, deliver));
  }
  require_done(pipeline.finish(deliver));
  return emitted;
}

double median_of(std::vector<float> values) {
  REQUIRE_FALSE(values.empty());
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return static_cast<double>(*middle);
}

}  // namespace

TEST_CASE("the depth that the poses tell weighs in the fit, and is the depth that leaves, in metres") {
  const Emitted emitted = emitted_by(plane(), EmitLayer::Merged);
  CHECK(emitted.losses.contains("depth"));
  CHECK(median_of(emitted.depth) == Approx(kDepth_m).epsilon(0.1));
}

TEST_CASE("the field is seen from where the camera is") {
  const Emitted state = emitted_by(plane(), EmitLayer::State), field = emitted_by(plane(), EmitLayer::Field);
  std::vector<float> stops;
  for (std::size_t p = 0; p < state.radiance.size(); ++p)
    stops.push_back(
        std::abs(std::log2(std::max(1e-3f, field.radiance[p]) / std::max(1e-3f, state.radiance[p]))));
  CHECK(median_of(stops) < 0.1);
}

}  // namespace hdrcam
