// The frames of a simulated clip: their times, their exposures and their facts.
#include "firmware_host/simulation/clip_timeline.h"

#include <fmt/format.h>

#include "tests/contracts/expect.h"

using namespace hdrcam;
using namespace std::chrono_literals;

namespace {

const std::vector<Exposure> kCycle{{1ms, 1}, {4ms, 1}, {16ms, 2}};

}  // namespace

TEST_CASE("the frames of a clip are evenly spaced by the middle of picture and exposure") {
  for (const char* scene : {"still?fps=50", "fast?fps=50"}) {
    const Simulation simulation = value_of(simulation_of(scene));
    const ClipTimeline timeline = value_of(ClipTimeline::create(simulation, kCycle));
    for (std::uint64_t i = 0; i < 6; ++i) {
      const Shot shot = timeline.shot(i);
      CHECK(shot.sequence == i);
      CHECK(shot.exposure_s == to_seconds(kCycle[i % 3].time));
      CHECK(shot.gain == kCycle[i % 3].gain);
      const double middle_s = shot.begin_s + (shot.exposure_s + to_seconds(simulation.readout())) / 2;
      CHECK(middle_s == Approx(static_cast<double>(i) * 0.02).margin(1e-12));
      CHECK(timeline.centre_s(i) == Approx(static_cast<double>(i) * 0.02));
    }
  }
}

TEST_CASE("the facts of a clip's frame are those of its exposure") {
  const Simulation simulation = value_of(simulation_of("still?fps=50&black=0.05&with=rolling-shutter"));
  const ClipTimeline timeline = value_of(ClipTimeline::create(simulation, kCycle));
  const FrameFacts facts = timeline.facts(5, true, 10);
  CHECK(facts.sequence == 5);
  CHECK(facts.slot == 2);
  CHECK(facts.exposure() == Approx(0.032));
  CHECK(facts.readout_s == Approx(0.012));
  CHECK(facts.timestamp == Instant{100ms});
  REQUIRE(facts.black_level);
  CHECK(facts.black_level->code(10) == Approx(0.05 * 1023));
  CHECK(facts.flags == kFrameAfterDrop);
  CHECK(timeline.facts(5, false, 10).flags == 0);
}

TEST_CASE("a clip goes on with the next frame that is not lost") {
  const Simulation simulation = value_of(simulation_of("still?drops=0.5"));
  const ClipTimeline timeline = value_of(ClipTimeline::create(simulation, kCycle));
  const StreamEffects stream(simulation);
  for (std::uint64_t i = 0; i < 100; ++i) {
    const std::uint64_t kept = value_of(timeline.next_kept(i));
    CHECK_FALSE(stream.loses(kept));
    for (std::uint64_t lost = i; lost < kept; ++lost) CHECK(stream.loses(lost));
  }
  const Simulation none = value_of(simulation_of("still?drops=1"));
  require_error(value_of(ClipTimeline::create(none, kCycle)).next_kept(0), ErrorCode::Invalid);
}

TEST_CASE("a clip's exposures fit its frames") {
  const Simulation simulation = value_of(simulation_of("still?fps=100"));
  require_error(ClipTimeline::create(simulation, kCycle), ErrorCode::BadExposure);
  CHECK(value_of(ClipTimeline::create(simulation, {{1ms, 1}, {10ms, 1}})).longest_exposure_s() == 0.01);
}

TEST_CASE("an exposure as long as a frame fits it, whichever way the two are rounded") {
  for (const int fps : {24, 30, 60, 120, 240}) {
    const Simulation simulation = value_of(simulation_of(fmt::format("still?fps={}", fps)));
    const std::vector<Exposure> whole = value_of(parse_exposures(fmt::format("1/{}", fps), "1"));
    INFO(fps << " fps");
    CHECK(ClipTimeline::create(simulation, whole).ok());
    require_error(ClipTimeline::create(simulation, {{whole[0].time + 1us, 1}}), ErrorCode::BadExposure);
  }
}

TEST_CASE("a clip has no gain at which a full pixel would not read as saturated") {
  const Simulation simulation = value_of(simulation_of("still"));
  const Error refusal = ClipTimeline::create(simulation, {{1ms, 1}, {4ms, 0.5}}).error();
  CHECK(refusal.code == ErrorCode::BadExposure);
  CHECK(refusal.message.find("gain 0.5") != std::string::npos);
  CHECK(value_of(ClipTimeline::create(simulation, {{1ms, 1}, {4ms, 1.5}})).shot(1).gain == 1.5);
}
