// What runs on a graphics device, beside the same on the processor with two threads: flow, state, look-ahead
// and shrinkage at 320x240, 640x480 and 1920x1080; a view of the field and its fit at 320x240.
// HDRCAM_TEST_GPU names the device. Transfers are part of the time. The label names what computed.
#include <benchmark/benchmark.h>

#include "online/priors/motion/vulkan/vulkan_flow.h"
#include "online/scene/hash_grid/field/field_renderer.h"
#include "online/scene/hash_grid/fit/field_fit.h"
#include "online/state/state_layer.h"
#include "render/shrinkage.h"
#include "tests/support/gpu.h"
#include "tests/support/moving_scene.h"

namespace hdrcam {
namespace {

constexpr int kWindow = 6;  // frames that a field is fitted to

struct Size {
  int rows, cols;
};
constexpr Size kSmall{240, 320};

Size size_of(const benchmark::State& state) {
  const auto rows = static_cast<int>(state.range(1));
  return {rows, rows == 1080 ? 1920 : rows * 4 / 3};
}

// One for all: some drivers take a second to open a device.
GpuDevice* the_gpu() {
  static const std::unique_ptr<GpuDevice> gpu = test::open_test_gpu();
  return gpu.get();
}

// What the device itself took of each iteration's time, by kernel and by transfer.
class DeviceTimes {
 public:
  DeviceTimes(benchmark::State& state, GpuDevice* gpu) : state_(state), gpu_(gpu) {
    if (gpu_ != nullptr) gpu_->work().measure(&times_);
  }
  ~DeviceTimes() {
    if (gpu_ == nullptr) return;
    gpu_->work().measure(nullptr);
    for (const auto& [step, took] : times_)
      state_.counters[step + "_us"] = benchmark::Counter(1000 * took.ms, benchmark::Counter::kAvgIterations);
  }
  DeviceTimes(const DeviceTimes&) = delete;
  DeviceTimes& operator=(const DeviceTimes&) = delete;

 private:
  benchmark::State& state_;
  GpuDevice* gpu_;
  GpuStepTimes times_;
};

struct Bench {
  Size size;
  test::MovingScene scene;
  WorkerPool pool{2};
  Response response = Response::gamma(2.2f);
  GpuDevice* gpu = nullptr;
  std::vector<ExposedFrame> frames;
  std::vector<ExposureTables> tables;
  FlowField motion;

  // The first argument says where: 0 the processor, 1 the graphics device.
  Bench(benchmark::State& state, const Size& of, int count = 2)
      : size(of), motion{Image<float>(2, of.rows, of.cols), Image<float>(1, of.rows, of.cols)} {
    scene.rows = size.rows, scene.cols = size.cols;
    if (state.range(0) == 1 && (gpu = the_gpu()) == nullptr)
      state.SkipWithError("there is no graphics device");
    state.SetLabel(gpu != nullptr ? gpu->facts().name : "processor");
    for (int i = 0; i < count; ++i) {
      frames.push_back(test::exposed(scene.frame(i), i));
      tables.emplace_back(response, NoiseModel(), frames.back().exposure);
    }
    std::fill_n(motion.vectors.plane(0), motion.vectors.plane_size(), -1.3f);
    std::fill_n(motion.vectors.plane(1), motion.vectors.plane_size(), 0.4f);
    motion.confidence.fill(1);
  }
  StateInput input(std::size_t i) const { return {frames[i], tables[i], 4}; }
};

void state_on_device(benchmark::State& state) {
  Bench bench(state, size_of(state));
  const auto layer = make_state_layer({}, bench.size.rows, bench.size.cols, bench.pool, bench.gpu);
  layer->restart(bench.input(0));
  const DeviceTimes times(state, bench.gpu);
  for (auto _ : state) layer->advance(bench.input(1), bench.motion);
}

// The flow of the defaults (Medium) between two frames, from a guess.
void flow_on_device(benchmark::State& state) {
  Bench bench(state, size_of(state));
  const auto [rows, cols] = bench.size;
  std::unique_ptr<DenseFlow> flow = std::make_unique<CpuFlow>(bench.pool);
  if (bench.gpu != nullptr) flow = std::make_unique<VulkanFlow>(rows, cols, bench.pool, *bench.gpu);
  const auto gray = [&](std::size_t i) {
    Image<float> green(1, bench.size.rows, bench.size.cols);
    std::copy_n(bench.frames[i].codes.plane(1), green.size(), green.plane(0));
    return green;
  };
  const Image<float> a = gray(0), b = gray(1);
  Image<float> there, back;
  FlowRequest request{&a, &b, &there, &back};
  request.start_a_to_b = {&bench.motion.vectors, -1, true}, request.start_b_to_a = {&bench.motion.vectors};
  flow->compute(FlowQuality::Medium, request);  // kernels are compiled, memory is taken
  const DeviceTimes times(state, bench.gpu);
  for (auto _ : state) flow->compute(FlowQuality::Medium, request);
}

void look_ahead_on_device(benchmark::State& state) {
  Bench bench(state, size_of(state));
  const auto layer = make_state_layer({}, bench.size.rows, bench.size.cols, bench.pool, bench.gpu);
  layer->restart(bench.input(0));
  const LaterFrame later{&bench.frames[1], &bench.motion, &bench.tables[1]};
  JoinedState joined;
  const DeviceTimes times(state, bench.gpu);
  for (auto _ : state) {
    ++bench.frames[1].index;  // another frame, whose codes are not on the device yet
    layer->join(layer->state(), {&later, 1}, 4, joined);
  }
}

void shrinkage_on_device(benchmark::State& state) {
  Bench bench(state, size_of(state));
  const auto layer = make_state_layer({}, bench.size.rows, bench.size.cols, bench.pool, nullptr);
  layer->restart(bench.input(0));
  Shrinkage shrink(bench.pool, bench.gpu);
  const DeviceTimes times(state, bench.gpu);
  for (auto _ : state) {
    Image<float> radiance = layer->state().radiance.clone();
    shrink.apply(radiance, layer->state().variance, {8e-4f});
  }
}

// A window's frames, all with the first one's state.
void observe_all(FieldFit& fit, const Bench& bench, const RadianceState& known, benchmark::State& state) {
  for (std::size_t i = 0; i < kWindow; ++i) {
    FieldObservation seen;
    seen.index = static_cast<int>(i), seen.time_s = static_cast<double>(i) / 30;
    seen.exposure = bench.frames[i].exposure;
    seen.codes = &bench.frames[i].codes;
    seen.radiance = &known.radiance, seen.variance = &known.variance;
    if (i > 0) seen.to_previous = &bench.motion, seen.from_previous = &bench.motion;
    if (!fit.observe(seen, bench.response)) state.SkipWithError("a frame was refused");
  }
}

void view_on_device(benchmark::State& state) {
  Bench bench(state, kSmall, kWindow);
  const auto layer = make_state_layer({}, bench.size.rows, bench.size.cols, bench.pool, nullptr);
  layer->restart(bench.input(0));
  const Intrinsics lens = *bench.scene.camera().intrinsics;
  FieldFit fit({}, lens, bench.size.rows, bench.size.cols, bench.pool);
  observe_all(fit, bench, layer->state(), state);
  SceneView view;
  view.time_s = 3 / 30.0, view.lens = lens, view.rows = bench.size.rows, view.cols = bench.size.cols;
  FieldRenderer renderer(bench.gpu);
  FieldPicture picture;
  const DeviceTimes times(state, bench.gpu);
  for (auto _ : state) renderer.render(fit.field(), view, bench.pool, picture);
  state.SetItemsProcessed(state.iterations() * bench.size.rows * bench.size.cols *
                          fit.field().samples_per_ray);
}

// The steps of one frame, as many and of as many rays as by default, on blocks of 2 x 2 pixels: what a stream
// of this size has.
void fit_on_device(benchmark::State& state) {
  Bench bench(state, kSmall, kWindow);
  const auto layer = make_state_layer({}, bench.size.rows, bench.size.cols, bench.pool, nullptr);
  layer->restart(bench.input(0));
  FieldOptions options;
  options.step_px = 2;
  FieldFit fit(options, *bench.scene.camera().intrinsics, bench.size.rows, bench.size.cols, bench.pool,
               bench.gpu);
  observe_all(fit, bench, layer->state(), state);
  FitBudget budget;
  budget.samples_without_parallax = static_cast<int>(state.range(1));
  fit.prepare(budget);
  const DeviceTimes times(state, bench.gpu);
  for (auto _ : state) {
    for (int s = 0; s < budget.steps; ++s) fit.step();
    fit.settle();
  }
  if (!fit.fallback_reason().empty()) state.SkipWithError(fit.fallback_reason().c_str());
  state.SetItemsProcessed(state.iterations() * budget.steps * budget.rays_per_step * state.range(1));
}

void in_all_sizes(benchmark::internal::Benchmark* bench) {
  bench->ArgNames({"on_gpu", "rows"})
      ->ArgsProduct({{0, 1}, {240, 480, 1080}})
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime();
}

BENCHMARK(flow_on_device)->Apply(in_all_sizes);
BENCHMARK(state_on_device)->Apply(in_all_sizes);
BENCHMARK(look_ahead_on_device)->Apply(in_all_sizes);
BENCHMARK(shrinkage_on_device)->Apply(in_all_sizes);
BENCHMARK(view_on_device)->ArgName("on_gpu")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(fit_on_device)
    ->ArgNames({"on_gpu", "samples_per_ray"})
    ->ArgsProduct({{0, 1}, {2, 8}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

}  // namespace
}  // namespace hdrcam
