// The sensor as a whole: the same in, the same out; only the effects of the plan; exposure means what it
// says.
#include "hal/sim/simulated_sensor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "hal/sim/effect_costs.h"
#include "tests/allocation_checks.h"
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

// Settings that leave out what scenes ask for by themselves, and add one effect; "": none.
std::string bare(std::string_view added) {
  std::string settings = "&without=control-delay";
  for (const std::string_view own : {"motion-blur", "noise", "vignetting", "response"})
    if (added != own) settings += fmt::format(",{}", own);
  return added.empty() ? settings : fmt::format("{}&with={}", settings, added);
}

const char* kEverything =
    "night?size=64x48&with=rolling-shutter,distortion,vignetting,flare,mains-flicker,hot-pixels,drops,clock-"
    "jitter";

}  // namespace

TEST_CASE("the same seed gives the same codes, on one thread and on two") {
  const auto once = codes_of(kEverything, 1);
  CHECK(same(once, codes_of(kEverything, 2)));
  CHECK(same(once, codes_of(kEverything, 1)));
  CHECK_FALSE(same(once, codes_of(fmt::format("{}&seed=2", kEverything), 1)));
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
  const std::string walk = "walk?size=160x120";
  const auto plain = codes_of(walk + bare({}), 1);
  for (const char* effect : {"motion-blur", "rolling-shutter", "distortion", "vignetting", "flare",
                             "mains-flicker", "hot-pixels", "noise", "response"}) {
    INFO(effect);
    CHECK_FALSE(same(codes_of(walk + bare(effect), 1), plain));
    CHECK(same(codes_of(fmt::format("{}{}&without={}", walk, bare({}), effect), 1), plain));
  }
}

TEST_CASE("an effect that is off is not there, one that is on is, and each for itself") {
  WorkerPool pool(1);
  const std::string walk = "walk?size=32x24";
  const auto scene =
      SimulatedSensor(value_of(simulation_of(walk + bare({}))), PixelLayout::Rgb, 8, pool).scene();
  const auto has_exactly = [&](const Simulation& simulation, std::vector<Effect> wanted, PixelLayout layout) {
    const SimulatedSensor sensor(simulation, layout, 8, pool, scene);
    wanted.push_back(Effect::Quantisation);
    for (std::size_t i = 0; i < kEffects; ++i) {
      const auto effect = static_cast<Effect>(i);
      INFO(name(effect));
      CHECK(sensor.has(effect) == (std::find(wanted.begin(), wanted.end(), effect) != wanted.end()));
    }
  };
  has_exactly(value_of(simulation_of(walk + bare({}))), {}, PixelLayout::Rgb);
  has_exactly(value_of(simulation_of(walk + bare("response"))), {Effect::Mosaic}, PixelLayout::BayerRggb);
  for (std::size_t i = 0; i < kEffects; ++i) {
    const auto effect = static_cast<Effect>(i);
    if (effect == Effect::Mosaic || effect >= Effect::ControlDelay) continue;  // the format's; the stream's
    has_exactly(value_of(simulation_of(walk + bare(name(effect)))), {effect}, PixelLayout::Rgb);
  }
}

TEST_CASE("an effect that is off holds no memory") {
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
  const std::string still = "still?size=64x48";
  const std::uint64_t least = allocations(still + bare({}));
  for (const char* effect : {"vignetting", "flare", "hot-pixels", "response"}) {  // those that hold memory
    INFO(effect);
    CHECK_ALLOCATIONS(allocations(still + bare(effect)) > least);
  }
}

TEST_CASE("costs are measured for what is on, touches pixels and can be left out, and add up to the frame") {
  WorkerPool pool(1);
  EffectCosts costs;
  const auto cost = [&](Effect effect) { return costs.effect_ms[static_cast<std::size_t>(effect)]; };
  for (int i = 0; i < 4 && !(cost(Effect::MotionBlur) > 0.); ++i)  // other programs may take the time of one
    costs = measure_costs(value_of(simulation_of("fast?size=160x120")), PixelLayout::Rgb, 8, 0.016,
                          std::chrono::milliseconds(500), pool);
  CHECK(costs.frame_ms > 0);
  CHECK(costs.bare_ms > 0);
  CHECK(costs.bare_ms < costs.frame_ms);
  REQUIRE(cost(Effect::MotionBlur));
  CHECK(*cost(Effect::MotionBlur) > 0);
  REQUIRE(cost(Effect::Noise));
  CHECK_FALSE(cost(Effect::Flare));
  CHECK_FALSE(cost(Effect::Quantisation));
  CHECK_FALSE(cost(Effect::ControlDelay));
  double sum_ms = costs.bare_ms;
  for (const auto& each : costs.effect_ms) sum_ms += each.value_or(0);
  CHECK(sum_ms == Approx(costs.frame_ms));
}

TEST_CASE("what falls on a scene at rest is kept, and what changes all the same does change") {
  const auto two_frames = [](const std::string& spec) {
    WorkerPool pool(1);
    SimulatedSensor sensor(value_of(simulation_of(spec)), PixelLayout::Rgb, 8, pool);
    Image<std::uint16_t> first, second;
    sensor.expose({0, 0.5, 0.004, 1}, first);
    sensor.expose({1, 0.533, 0.004, 1}, second);
    return same({first.samples().begin(), first.samples().end()},
                {second.samples().begin(), second.samples().end()});
  };
  CHECK(two_frames("still?size=64x48&without=noise"));
  CHECK_FALSE(two_frames("still?size=64x48"));
  CHECK_FALSE(two_frames("still?size=64x48&without=noise&with=mains-flicker"));
  CHECK_FALSE(two_frames("walk?size=64x48&without=noise"));
}

TEST_CASE("one ray a pixel shows the same scene, only rougher") {
  const std::string spec = "walk?size=160x120&without=noise";
  const Codes smooth = codes_of(spec, 1), rough = codes_of(spec + "&rays=1", 1);
  double difference = 0;
  for (std::size_t i = 0; i < smooth.size(); ++i) difference += std::abs(smooth[i] - rough[i]);
  CHECK_FALSE(same(smooth, rough));
  CHECK(difference / static_cast<double>(smooth.size()) < 6);  // codes of 255
}

TEST_CASE("an exposure allocates nothing after the first") {
  WorkerPool pool(2);
  SimulatedSensor sensor(value_of(simulation_of(kEverything)), PixelLayout::Rgb, 8, pool);
  Image<std::uint16_t> codes;
  sensor.expose({0, 0.5, 0.016, 1}, codes);
  const std::uint64_t before = allocations_so_far();
  for (std::uint64_t i = 1; i < 6; ++i)
    sensor.expose({i, 0.5 + static_cast<double>(i) / 30, 0.016, 1}, codes);
  CHECK_ALLOCATIONS(allocations_so_far() == before);
}
