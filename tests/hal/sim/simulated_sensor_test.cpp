// The sensor as a whole: the same in, the same out; only the effects of the plan; exposure means what it
// says.
#include "hal/sim/simulated_sensor.h"

#include <vector>

#include "hal/sim/effect_costs.h"
#include "tests/allocations.h"
#include "tests/contracts/expect.h"

using namespace hdrcam;

namespace {

using Codes = std::vector<std::uint16_t>;
bool same(const Codes& a, const Codes& b) { return a == b; }  // without printing thousands of them

Codes codes_of(const std::string& spec, int threads, PixelLayout layout = PixelLayout::Rgb, int bits = 8,
               Shot shot = {7, 0.5, 0.016, 1}) {
  WorkerPool pool(threads);
  SimulatedSensor sensor(value_of(simulation_of(spec)), layout, bits, pool);
  Image<std::uint16_t> codes;
  sensor.expose(shot, codes);
  return {codes.samples().begin(), codes.samples().end()};
}

const char* kEverything =
    "night?size=64x48&with=rolling-shutter,distortion,vignetting,flare,mains-flicker,hot-pixels,drops,clock-"
    "jitter";

}  // namespace

TEST_CASE("the same seed gives the same codes, on one thread and on two") {
  const auto once = codes_of(kEverything, 1);
  CHECK(same(once, codes_of(kEverything, 2)));
  CHECK(same(once, codes_of(kEverything, 1)));
  CHECK_FALSE(same(once, codes_of(std::string(kEverything) + "&seed=2", 1)));
  CHECK(same(codes_of(kEverything, 1, PixelLayout::BayerGrbg, 12),
             codes_of(kEverything, 2, PixelLayout::BayerGrbg, 12)));
}

TEST_CASE("without noise and response a code is radiance times exposure, up to saturation") {
  const std::string spec = "still?size=64x48&without=noise,response";
  WorkerPool pool(1);
  SimulatedSensor sensor(value_of(simulation_of(spec)), PixelLayout::Rgb, 12, pool);
  Image<std::uint16_t> codes;
  for (const Shot& shot : {Shot{0, 0.5, 0.001, 1}, Shot{1, 0.5, 0.016, 1}, Shot{2, 0.5, 0.004, 4}}) {
    sensor.expose(shot, codes);
    int saturated = 0;
    for (std::size_t i = 0; i < codes.size(); ++i) {
      const double x = static_cast<double>(sensor.light().samples()[i]) * shot.exposure_s * shot.gain * 167.5;
      REQUIRE(codes.samples()[i] == Approx(std::min(x, 1.0) * 4095).margin(1));
      saturated += codes.samples()[i] == 4095;
    }
    CHECK(saturated > 0);
  }
}

TEST_CASE("a Bayer picture is the colour picture seen through the mosaic") {
  const std::string spec = "still?size=64x48&without=noise,response";
  const auto rgb = codes_of(spec, 1, PixelLayout::Rgb, 12),
             raw = codes_of(spec, 1, PixelLayout::BayerRggb, 12);
  const Mosaic mosaic(PixelLayout::BayerRggb);
  REQUIRE(raw.size() * 3 == rgb.size());
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) {
      const auto pixel = static_cast<std::size_t>(y * 64 + x);
      REQUIRE(raw[pixel] == rgb[static_cast<std::size_t>(mosaic.channel(y, x)) * 64 * 48 + pixel]);
    }
}

TEST_CASE("each effect that is switched on changes the picture, and only then") {
  const std::string base = "walk?size=160x120&without=motion-blur,noise,vignetting,response";
  const auto plain = codes_of(base, 1);
  for (const char* effect : {"motion-blur", "rolling-shutter", "distortion", "vignetting", "flare",
                             "mains-flicker", "hot-pixels", "noise", "response"}) {
    INFO(effect);
    const std::string more = fmt::format("{}&with={}", base, effect);
    CHECK_FALSE(same(codes_of(more, 1), plain));
    CHECK(same(codes_of(fmt::format("{}&without={}", more, effect), 1), plain));
  }
}

TEST_CASE("an effect that is off is not constructed") {
  const auto allocations = [](const std::string& spec) {
    WorkerPool pool(1);
    const Simulation simulation = value_of(simulation_of(spec));
    const auto scene = SimulatedSensor(simulation, PixelLayout::Rgb, 8, pool).scene();
    const std::uint64_t before = allocations_so_far();
    SimulatedSensor sensor(simulation, PixelLayout::Rgb, 8, pool, scene);
    Image<std::uint16_t> codes;
    sensor.expose({0, 0.5, 0.004, 1}, codes);
    return allocations_so_far() - before;
  };
  const std::string bare = "still?size=64x48&without=noise,response,control-delay";
  const std::uint64_t least = allocations(bare);
  for (const char* effect : {"vignetting", "flare", "hot-pixels", "response"}) {  // those that hold memory
    INFO(effect);
    CHECK(allocations(fmt::format("{}&with={}", bare, effect)) > least);
    CHECK(allocations(fmt::format("{0}&with={1}&without={1}", bare, effect)) == least);
  }
}

TEST_CASE("costs are measured for what is on, touches pixels and can be left out") {
  WorkerPool pool(1);
  const EffectCosts costs =
      measure_costs(value_of(simulation_of("fast?size=160x120")), PixelLayout::Rgb, 8, 0.016, 4, pool);
  const auto cost = [&](Effect effect) { return costs.effect_ms[static_cast<std::size_t>(effect)]; };
  CHECK(costs.frame_ms > 0);
  CHECK(costs.bare_ms > 0);
  CHECK(costs.bare_ms < costs.frame_ms);
  REQUIRE(cost(Effect::MotionBlur));
  REQUIRE(cost(Effect::Noise));
  CHECK(*cost(Effect::Noise) > 0);
  CHECK_FALSE(cost(Effect::Flare));
  CHECK_FALSE(cost(Effect::Quantisation));
  CHECK_FALSE(cost(Effect::ControlDelay));
}

TEST_CASE("an exposure allocates nothing after the first") {
  WorkerPool pool(2);
  SimulatedSensor sensor(value_of(simulation_of(kEverything)), PixelLayout::Rgb, 8, pool);
  Image<std::uint16_t> codes;
  sensor.expose({0, 0.5, 0.016, 1}, codes);
  const std::uint64_t before = allocations_so_far();
  for (std::uint64_t i = 1; i < 6; ++i)
    sensor.expose({i, 0.5 + static_cast<double>(i) / 30, 0.016, 1}, codes);
  CHECK(allocations_so_far() == before);
}
