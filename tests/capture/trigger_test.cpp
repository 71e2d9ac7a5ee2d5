// A trigger that drives its line, in virtual and in real time.
#include "capture/trigger.h"

#include <thread>

#include "capture/trigger_thread.h"
#include "hal/fault/faulty_trigger_line.h"
#include "hal/sim/simulated_trigger_line.h"
#include "tests/allocation_checks.h"
#include "tests/capture/trigger_cycle.h"

namespace hdrcam {
namespace {

using namespace std::chrono_literals;
using Catch::Contains;
using test::options_of;
using test::schedule_of;

// A trigger in virtual time, and the other end of its wire.
struct Driven {
  explicit Driven(TriggerMode mode, std::vector<TriggerFault> faults = {})
      : trigger(std::make_unique<FaultyTriggerLine>(std::make_unique<SimulatedTriggerLine>(wire),
                                                    std::move(faults), clock),
                options_of(mode), clock) {
    require_done(trigger.start(schedule_of(test::kTriggerCycle)));
  }
  VirtualClock clock;
  SimulatedWire wire{SimTime(clock)};
  SimulatedSyncLine seen{wire};
  Trigger trigger;
};

TEST_CASE("every pulse that is driven is seen on the wire, at the instants that were reported") {
  Driven driven(TriggerMode::PulseWidth);
  std::uint64_t in_pulses = 0;
  for (int i = 0; i < 60; ++i) {
    const std::uint64_t before = allocations_so_far();
    const bool drove = driven.trigger.drive_next();
    const auto pulse = driven.trigger.take();
    in_pulses += allocations_so_far() - before;
    REQUIRE(drove);
    REQUIRE(pulse);
    REQUIRE(pulse->planned.number == static_cast<std::uint64_t>(i));
    REQUIRE(pulse->width() == test::kTriggerCycle[i % 3].time);
    REQUIRE_FALSE(pulse->late);
    REQUIRE(value_of(driven.seen.wait_edge(0us)).at == pulse->rise.at);
    REQUIRE(value_of(driven.seen.wait_edge(0us)).at == pulse->fall.at);
  }
  CHECK_ALLOCATIONS(in_pulses == 0);
  CHECK_FALSE(driven.wire.level());
  CHECK(driven.trigger.driven() == 60);
}

TEST_CASE("a line that goes away ends the pulses, and says why") {
  Driven driven(TriggerMode::PulseWidth, {{2, TriggerFaultKind::Unplug}});
  CHECK(driven.trigger.drive_next());
  CHECK(driven.trigger.drive_next());
  CHECK_FALSE(driven.trigger.failure());
  CHECK_FALSE(driven.trigger.drive_next());
  CHECK_FALSE(driven.trigger.drive_next());
  REQUIRE(driven.trigger.failure());
  CHECK(driven.trigger.failure()->code == ErrorCode::Unplugged);
}

TEST_CASE("a schedule that follows another is driven from the next pulse on") {
  Driven driven(TriggerMode::PulseWidth);
  CHECK(driven.trigger.drive_next());
  const Exposure shorter[] = {{2ms, 1}, {2500us, 1}, {3ms, 1}};
  require_done(driven.trigger.follow(schedule_of(shorter)));
  CHECK(driven.trigger.drive_next());
  (void)driven.trigger.take();
  CHECK(driven.trigger.take()->width() == 2500us);
  const Exposure too_long[] = {{20ms, 1}};
  require_error(driven.trigger.follow(schedule_of(too_long)), ErrorCode::BadExposure);
}

TEST_CASE(
    "in real time the thread drives every pulse in order, and leaves the line inactive when it is stopped") {
  SimulatedWire wire{SimTime()};
  SimulatedSyncLine seen(wire);
  Trigger trigger(std::make_unique<SimulatedTriggerLine>(wire), options_of(TriggerMode::PulseWidth),
                  posix_clock());
  const TriggerThread thread(trigger);
  if (!thread.realtime()) CHECK_THAT(thread.realtime().error().message, Contains("ulimit -r 50"));
  for (int run = 0; run < 2; ++run) {
    require_done(trigger.start(schedule_of(test::kTriggerCycle)));
    std::vector<TriggerPulse> pulses;
    for (int i = 0; i < 2000 && pulses.size() < 12; ++i) {
      while (const auto pulse = trigger.take()) pulses.push_back(*pulse);
      std::this_thread::sleep_for(2ms);
    }
    trigger.stop();
    CHECK_FALSE(wire.level());
    while (const auto pulse = trigger.take()) pulses.push_back(*pulse);
    REQUIRE(pulses.size() >= 12);
    CHECK(pulses.size() == trigger.driven());
    for (const TriggerPulse& pulse : pulses) {
      const Edge rise = value_of(seen.wait_edge(0us)), fall = value_of(seen.wait_edge(0us));
      CHECK(rise.at == pulse.rise.at);
      CHECK(fall.at == pulse.fall.at);
      // however busy the machine, a pulse is never early and never too short, and where it is not late, it is
      // right
      CHECK(pulse.begin_error() >= 0us);
      CHECK(pulse.width_error() >= 0us);
      CHECK(pulse.late == (pulse.begin_error() > 500us || pulse.width_error() > 500us));
    }
    require_error(seen.wait_edge(0us), ErrorCode::Timeout);
  }
}

}  // namespace
}  // namespace hdrcam
