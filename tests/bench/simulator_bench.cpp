// What a simulated frame of 320x240 costs on one thread: the scenes of the catalogue, a frame without effects
// against a renderer and a rounding loop that know none, each effect alone, and all together.
// hal/sim/README.md holds the results of one machine. --benchmark_repetitions=9 and the smallest time are
// what it takes on a busy one.
#include <benchmark/benchmark.h>

#include "hal/sim/simulated_camera.h"

namespace hdrcam {
namespace {

constexpr double kBegin_s = 0.5, kExposure_s = 0.016;
// Something of everything: motion, lamps, surfaces that are lit.
const char* kBare = "lamps?without=noise,response,control-delay,motion-blur,flare";

Simulation simulation(const std::string& spec) { return simulation_of(spec).value(); }

void expose_frames(benchmark::State& state, const Simulation& what) {
  WorkerPool pool(1);
  SimulatedSensor sensor(what, PixelLayout::Rgb, 8, pool);
  Image<std::uint16_t> codes;
  std::uint64_t sequence = 0;
  for (auto _ : state)
    sensor.expose({sequence++, kBegin_s, kExposure_s, 1}, codes), benchmark::DoNotOptimize(codes.plane(0));
}

void scene_frame(benchmark::State& state) {
  const auto& entry = scene_catalog()[static_cast<std::size_t>(state.range(0))];
  state.SetLabel(entry.name);
  expose_frames(state, simulation(entry.name));
}

void all_effects_off(benchmark::State& state) { expose_frames(state, simulation(kBare)); }

// The same picture by code in which no effect occurs: the measure of what switched-off effects cost.
void no_effect_code(benchmark::State& state) {
  const Simulation s = simulation(kBare);
  WorkerPool pool(1);
  const SimulatedSensor made(s, PixelLayout::Rgb, 8, pool);
  Renderer renderer(*made.scene(), made.lens(), {}, s.height, s.width, pool);
  const Quantiser quantiser(8, 0);
  const auto per_light = static_cast<float>(kExposure_s * s.sensitivity_per_s);
  Image<float> light;
  Image<std::uint16_t> codes(3, s.height, s.width);
  for (auto _ : state) {
    renderer.render({kBegin_s, kBegin_s + kExposure_s}, light);
    for (std::size_t i = 0; i < codes.size(); ++i)
      codes.samples()[i] = quantiser.code(std::min(light.samples()[i] * per_light, 1.f));
    benchmark::DoNotOptimize(codes.plane(0));
  }
}

void one_effect(benchmark::State& state) {
  const auto effect = static_cast<Effect>(state.range(0));
  state.SetLabel(name(effect));
  Simulation s = simulation(kBare);
  s.plan.switch_on(effect, "measured");
  expose_frames(state, s);
}

void every_effect(benchmark::State& state) {
  Simulation s = simulation(kBare);
  for (std::size_t i = 0; i < kEffects; ++i)
    if (static_cast<Effect>(i) != Effect::Mosaic) s.plan.switch_on(static_cast<Effect>(i), "measured");
  expose_frames(state, s);
}

// From the request to the buffer, the exposures of the cycle 1, 4, 16 ms in turn; time itself costs nothing.
void film(benchmark::State& state, const std::string& spec, Duration longest) {
  VirtualClock clock;
  SimulatedCamera camera(simulation(spec), SimTime(clock), 1);
  const CameraCapabilities& can = camera.capabilities();
  camera.configure({PixelFormat::Rgb24, 0, 0, can.usual_frame_duration}, 4).value();
  camera.start().value();
  std::uint64_t cookie = 0;
  const auto queue = [&] {
    const Duration exposures[] = {longest / 16, longest / 4, longest};
    const auto steps = exposures[cookie % 3] / can.exposure_step;
    camera.queue({cookie, std::chrono::round<Duration>(steps * can.exposure_step), 1}).value();
    ++cookie;
  };
  for (int i = 0; i < 4; ++i) queue();
  for (auto _ : state) {
    benchmark::DoNotOptimize(camera.wait(std::chrono::seconds(1)).value().pixels.data());
    queue();
  }
}

void camera_frame(benchmark::State& state) {
  const auto& entry = scene_catalog()[static_cast<std::size_t>(state.range(0))];
  state.SetLabel(entry.name);
  film(state, entry.name, std::chrono::milliseconds(16));
}

void small_camera_frame(benchmark::State& state) {
  const std::string spec = fmt::format("walk?size=32x24&fps=500&rays={}", state.range(0));
  state.SetLabel(spec);
  film(state, spec, std::chrono::microseconds(1600));
}

void quick_frame(benchmark::State& state) { film(state, "walk?rays=1", std::chrono::milliseconds(16)); }

constexpr std::int64_t index(Effect effect) { return static_cast<std::int64_t>(effect); }

BENCHMARK(scene_frame)->DenseRange(0, 5)->Unit(benchmark::kMillisecond);
BENCHMARK(camera_frame)->DenseRange(0, 5)->Unit(benchmark::kMillisecond);
BENCHMARK(small_camera_frame)->Arg(4)->Arg(1)->Unit(benchmark::kMillisecond);
BENCHMARK(no_effect_code)->Unit(benchmark::kMillisecond);
BENCHMARK(all_effects_off)->Unit(benchmark::kMillisecond);
BENCHMARK(quick_frame)->Unit(benchmark::kMillisecond);
BENCHMARK(every_effect)->Unit(benchmark::kMillisecond);
BENCHMARK(one_effect)
    ->DenseRange(index(Effect::MotionBlur), index(Effect::MainsFlicker))
    ->Arg(index(Effect::HotPixels))
    ->Arg(index(Effect::Noise))
    ->Arg(index(Effect::Response))
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace hdrcam
