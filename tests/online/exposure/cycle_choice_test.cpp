// The exposures that the fit asks for, on a pattern that moves as fast and is as bright as a test says. The
// state is as it would be: the pattern with some noise.
#include "online/exposure/cycle_choice.h"

#include <cmath>
#include <numbers>

#include "hal/sim/counter_random.h"
#include "tests/online/exposure/estimate_of.h"
#include "tests/support/uniform_flow.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using namespace std::chrono_literals;

namespace {

struct Pattern {
  float speed_px = 0;        // per frame interval, to the right
  float brightness = 0.15f;  // mean radiance; 1 saturates the reference exposure
  float contrast = 0.5f;     // of the brightness
  float noise = 0.01f;       // of the radiance, in the state
};

constexpr auto kInterval = 33'333'333ns;

ExposureLimits limits_of(std::vector<Exposure> cycle) {
  return {.cycle = std::move(cycle), .shortest = 50us, .longest = 32ms, .least_gain = 1, .greatest_gain = 8};
}
const std::vector<Exposure> kCycle{{1ms, 1}, {4ms, 1}, {16ms, 1}};

// A camera without a lens: its frames have the exposures of the cycle that was asked for last, unless it
// refuses that.
class Loop {
 public:
  Loop(const ExposureLimits& limits, const Pattern& pattern, const StateOptions& state = {})
      : pattern_(pattern), choice_(limits, state), reference_(1) {
    for (const Exposure& exposure : limits.cycle)
      reference_ *= std::pow(exposure.product(), 1.0 / static_cast<double>(limits.cycle.size()));
    frame_.codes = Image<float>(3, kRows, kCols);
    state_.radiance = Image<float>(3, kRows, kCols), state_.variance = Image<float>(3, kRows, kCols);
  }

  // Runs so many frames. Returns how often the cycle changed.
  int run(int frames) {
    int changes = 0;
    for (int i = 0; i < frames; ++i) changes += step() ? 1 : 0;
    return changes;
  }
  void set_pattern(const Pattern& pattern) { pattern_ = pattern; }
  void set_refuses(bool refuses) { refuses_ = refuses; }
  const std::vector<Exposure>& cycle() const { return choice_.cycle(); }
  const std::optional<CycleRequest>& request() const { return request_; }

 private:
  static constexpr int kRows = 48, kCols = 64;

  bool step() {
    const Exposure& exposure = choice_.cycle()[frames_ % choice_.cycle().size()];
    frame_.facts.exposure_s = to_seconds(exposure.time), frame_.facts.analogue_gain = exposure.gain;
    frame_.facts.timestamp = Instant{kInterval * static_cast<Duration::rep>(frames_)};
    frame_.exposure = static_cast<float>(exposure.product() / reference_);
    frame_.reference_exposure = reference_;
    frame_.interval_s = to_seconds(kInterval);
    frame_.blur_fraction = static_cast<float>(to_seconds(exposure.time) / to_seconds(kInterval));
    const CounterRandom random(1, 2, frames_);
    const float noise = pattern_.noise * pattern_.brightness;
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < kRows; ++y)
        for (int x = 0; x < kCols; ++x) {
          const float place = static_cast<float>(x) - pattern_.speed_px * static_cast<float>(frames_);
          const float wave = std::sin(place * 2 * std::numbers::pi_v<float> / 7);
          const auto pixel = static_cast<std::uint64_t>((c * kRows + y) * kCols + x) * 2;
          state_.radiance.at(c, y, x) =
              pattern_.brightness * (1 + pattern_.contrast * wave) + noise * random.normals(pixel).a;
          state_.variance.at(c, y, x) = noise * noise;
        }
    const FlowField flow = test::uniform_flow(kRows, kCols, -pattern_.speed_px);
    const FrameEstimate estimate = test::estimate_of(frame_, state_, flow, nullptr, reference_);
    ++frames_;
    auto request = choice_.observe(estimate, {response_, noise_, 1});
    if (request && !refuses_) choice_.runs(*request);
    if (request) request_ = std::move(request);
    return request_ && request_->cycle == choice_.cycle() &&
           std::exchange(last_, request_->cycle) != request_->cycle;
  }

  const Response response_ = Response::gamma(2.2f);
  const NoiseModel noise_;
  Pattern pattern_;
  CycleChoice choice_;
  double reference_;
  std::uint64_t frames_ = 0;
  bool refuses_ = false;
  ExposedFrame frame_;
  RadianceState state_;
  std::optional<CycleRequest> request_;
  std::vector<Exposure> last_;
};

double seconds_of(const std::vector<Exposure>& cycle) {
  double sum = 0;
  for (const Exposure& exposure : cycle) sum += to_seconds(exposure.time);
  return sum;
}

}  // namespace

TEST_CASE("where everything moves the times get shorter, where nothing does they do not") {
  Loop moving(limits_of(kCycle), {.speed_px = 8}), resting(limits_of(kCycle), {});
  moving.run(120), resting.run(120);
  REQUIRE(moving.request());
  INFO(describe(*moving.request()));
  CHECK(moving.cycle()[2].time <= 8ms);
  CHECK(seconds_of(moving.cycle()) < 0.6 * seconds_of(kCycle));
  CHECK(moving.request()->blur_share > 0.3);
  CHECK(seconds_of(resting.cycle()) >= seconds_of(kCycle));
}

TEST_CASE(
    "where the state takes samples for worse than any blur makes them, no other cycle is worth a change") {
  Loop doubting(limits_of(kCycle), {.speed_px = 8}, {.fusion = {.relative_noise = 0.5f}});
  doubting.run(120);
  CHECK_FALSE(doubting.request());
}

TEST_CASE("a cycle of short times and high gains gets long times and low gains once all is at rest") {
  const std::vector<Exposure> short_times{{250us, 4}, {1ms, 4}, {4ms, 4}};
  Loop loop(limits_of(short_times), {.brightness = 0.02f});
  loop.run(240);
  CHECK(seconds_of(loop.cycle()) > 2 * seconds_of(short_times));
  CHECK(loop.cycle()[2].gain < 3);
}

TEST_CASE("a gain that comes down by half stops ends at the least one, not a rounding above it") {
  const double half_stop = std::sqrt(2.0);
  Loop loop(limits_of({{250us, half_stop}, {1ms, half_stop}, {4ms, half_stop}}), {.brightness = 0.02f});
  loop.run(240);
  INFO(describe(loop.cycle()));
  CHECK(loop.cycle()[2].gain == 1);
  for (const Exposure& exposure : loop.cycle()) CHECK((exposure.gain == 1 || exposure.gain > 1.1));
}

TEST_CASE("gain takes the place of time where something moves in the dark") {
  Loop loop(limits_of(kCycle), {.speed_px = 10, .brightness = 0.02f});
  loop.run(240);
  CHECK(loop.cycle()[2].gain > 1.4);
  CHECK(loop.cycle()[2].time < 16ms);
}

TEST_CASE("whatever moves and however bright it is, no exposure leaves the sensor's limits or its slot") {
  for (const float speed : {0.f, 0.5f, 3.f, 12.f, 40.f})
    for (const float brightness : {0.0005f, 0.02f, 1.f, 30.f}) {
      const ExposureLimits limits = limits_of(kCycle);
      Loop loop(limits, {.speed_px = speed, .brightness = brightness});
      loop.run(200);
      INFO(speed << " px, brightness " << brightness);
      const auto& cycle = loop.cycle();
      REQUIRE(cycle.size() == kCycle.size());
      for (const Exposure& exposure : cycle) {
        CHECK(exposure.time >= limits.shortest);
        CHECK(exposure.time <= limits.longest);
        CHECK(exposure.gain >= limits.least_gain);
        CHECK(exposure.gain <= limits.greatest_gain);
      }
      // the highlights of the first cycle stay as they were kept, and the proof of labels needs different
      // exposures
      CHECK(cycle[0].product() == Approx(kCycle[0].product()).epsilon(0.02));
      CHECK(cycle[1].product() > 1.9 * cycle[0].product());
      CHECK(cycle[2].product() > 1.9 * cycle[1].product());
    }
}

TEST_CASE("lamps do not begin to flicker: a time of whole half periods stays one") {
  ExposureLimits limits = limits_of({{1ms, 1}, {10ms, 1}, {30ms, 1}});
  limits.mains = Mains::Hz50;
  Loop loop(limits, {.speed_px = 10});
  loop.run(240);
  CHECK(loop.request());
  CHECK(loop.cycle()[0].time < 10ms);
  CHECK(loop.cycle()[1].time % 10ms == 0ns);
  CHECK(loop.cycle()[2].time % 10ms == 0ns);

  // 1/120 s on a sensor with lines of 10 us
  ExposureLimits rounded = limits_of({{1ms, 1}, {8330us, 1}, {25ms, 1}});
  rounded.mains = Mains::Hz60;
  Loop at_60(rounded, {.speed_px = 10});
  at_60.run(240);
  CHECK(at_60.request());
  CHECK(lasts(at_60.cycle()[1].time, half_period(Mains::Hz60)));
}

TEST_CASE("a scene that stays as it is changes the cycle a few times at most, then never again") {
  for (const float speed : {0.f, 1.5f, 6.f}) {
    Loop loop(limits_of(kCycle), {.speed_px = speed, .noise = 0.1f});
    const int first = loop.run(200), later = loop.run(1000);
    INFO(speed << " px: " << first << " changes, then " << later);
    CHECK(first <= 3);
    CHECK(later == 0);
  }
}

TEST_CASE("exposures that are as near as they may be get shorter together where everything moves") {
  // a stop apart, the two longer ones may neither come nearer nor part
  const std::vector<Exposure> near{{1ms, 1}, {8ms, 1}, {16ms, 1}};
  ExposureLimits limits = limits_of(near);
  limits.greatest_gain = 1;
  Loop loop(limits, {.speed_px = 8});
  loop.run(120);
  INFO(describe(loop.cycle()));
  CHECK(loop.cycle()[1].time <= near[1].time / 2);
  CHECK(loop.cycle()[2].time <= near[2].time / 2);
}

TEST_CASE("the cycle follows when what moved comes to rest") {
  Loop loop(limits_of(kCycle), {.speed_px = 8});
  loop.run(200);
  const double moving_s = seconds_of(loop.cycle());
  loop.set_pattern({});
  loop.run(200);
  CHECK(seconds_of(loop.cycle()) > 1.4 * moving_s);
}

TEST_CASE("the summary counts the requests in words") {
  CycleChoice choice(limits_of(kCycle), {});
  const CycleRequest request{.cycle = kCycle, .error_before = 1, .error_after = 0.5};
  choice.runs(request);
  CHECK_THAT(choice.summary(), Catch::Contains("other exposures 1 time; last for "));
  choice.runs(request);
  CHECK_THAT(choice.summary(), Catch::Contains("other exposures 2 times; last for "));
}

TEST_CASE("the cycle before goes on where the camera refuses the one that the fit asks for") {
  Loop loop(limits_of(kCycle), {.speed_px = 8});
  loop.set_refuses(true);
  loop.run(120);
  REQUIRE(loop.request());
  CHECK(loop.request()->cycle != kCycle);
  CHECK(loop.cycle() == kCycle);
  loop.set_refuses(false);
  loop.run(120);
  CHECK(loop.cycle() == loop.request()->cycle);
}
