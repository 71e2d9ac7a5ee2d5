// The parts of one frame's way at 320x240, on one thread and on two: where the time goes. Ratios within one
// run mean something, times from different machines do not.
#include <benchmark/benchmark.h>

#include "online/pictures/local_statistics.h"
#include "online/pictures/warp.h"
#include "online/priors/motion/motion_estimator.h"
#include "online/response/response_estimator.h"
#include "online/scene/hash_grid/field/field_renderer.h"
#include "online/scene/hash_grid/fit/field_fit.h"
#include "online/state/state_filter.h"
#include "render/shrinkage.h"
#include "tests/support/moving_scene.h"

namespace hdrcam {
namespace {

const float kUnseen = unseen_variance_from(4);

struct Bench {
  test::MovingScene scene;
  WorkerPool pool;
  Response response = Response::gamma(2.2f);
  std::vector<ExposedFrame> frames;
  ExposureTables tables;
  StateFilter filter;
  StateMotion motion;

  explicit Bench(int threads)
      : scene(large()),
        pool(threads),
        frames(exposed(scene)),
        tables(response, {}, frames[1].exposure),
        filter({}, scene.rows, scene.cols, pool) {
    filter.restart({frames[0], ExposureTables(response, {}, frames[0].exposure), kUnseen});
    MotionEstimator(scene.rows, scene.cols, pool)
        .match(filter.state(), frames[1], tables, {FlowQuality::Medium}, {}, motion);
  }
  static test::MovingScene large() {
    test::MovingScene scene;
    scene.rows = 240, scene.cols = 320;
    return scene;
  }
  static std::vector<ExposedFrame> exposed(const test::MovingScene& scene) {
    std::vector<ExposedFrame> frames;
    for (int i = 0; i < 6; ++i) frames.push_back(test::exposed(scene.frame(i), i));
    return frames;
  }
};

int threads(const benchmark::State& state) { return static_cast<int>(state.range(0)); }

void response_estimate(benchmark::State& state) {
  Bench bench(1);
  for (auto _ : state) {
    ResponseEstimator estimator;
    for (std::size_t i = 1; i < bench.frames.size(); ++i)
      estimator.add_pair(bench.frames[i - 1], bench.frames[i]);
    benchmark::DoNotOptimize(estimator.estimate({}));
  }
}

void motion_match(benchmark::State& state) {
  Bench bench(threads(state));
  MotionEstimator motion(bench.scene.rows, bench.scene.cols, bench.pool);
  for (auto _ : state)
    motion.match(bench.filter.state(), bench.frames[1], bench.tables, {FlowQuality::Medium}, {},
                 bench.motion);
}

void state_advance(benchmark::State& state) {
  Bench bench(threads(state));
  const ExposedFrame& frame = bench.frames[1];
  for (auto _ : state) bench.filter.advance({frame, bench.tables, kUnseen}, bench.motion.to_previous);
}

void warp_radiance_rgb(benchmark::State& state) {
  Bench bench(threads(state));
  Image<float> out;
  for (auto _ : state)
    warp_radiance(bench.filter.state().radiance, bench.motion.to_previous.vectors, out, bench.pool);
}

void shrinkage(benchmark::State& state) {
  Bench bench(threads(state));
  Shrinkage shrinkage(bench.pool);
  auto radiance = bench.filter.state().radiance.clone();
  for (auto _ : state) shrinkage.apply(radiance, bench.filter.state().variance, {1e-3f});
}

struct FieldBench : Bench {
  FieldFit fit;
  FieldBench(int threads)
      : Bench(threads), fit(FieldOptions(), *scene.camera().intrinsics, scene.rows, scene.cols, pool) {
    for (int i = 0; i < 2; ++i) {
      FieldObservation seen;
      seen.index = i, seen.time_s = i / 30.;
      const auto& frame = frames[static_cast<std::size_t>(i)];
      seen.exposure = frame.exposure, seen.blur_fraction = frame.blur_fraction;
      seen.codes = &frame.codes;
      seen.radiance = &filter.state().radiance;
      seen.variance = &filter.state().variance;
      if (i > 0) seen.to_previous = &motion.to_previous, seen.from_previous = &motion.from_previous;
      fit.observe(seen, response).value();
    }
  }
};

void field_step(benchmark::State& state) {
  FieldBench bench(threads(state));
  for (auto _ : state) benchmark::DoNotOptimize(bench.fit.step());
}

void field_render(benchmark::State& state) {
  FieldBench bench(threads(state));
  FieldRenderer renderer;
  FieldPicture picture;
  SceneView view;
  view.time_s = 1 / 30.;
  view.lens = *bench.scene.camera().intrinsics, view.rows = bench.scene.rows, view.cols = bench.scene.cols;
  for (auto _ : state) renderer.render(bench.fit.field(), reduced(view, 2), bench.pool, picture);
}

BENCHMARK(response_estimate)->Unit(benchmark::kMillisecond);
BENCHMARK(motion_match)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(warp_radiance_rgb)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(state_advance)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(shrinkage)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(field_step)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(field_render)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace hdrcam
