#include "hal/sim/simulated_sync_line.h"

#include "hal/fault/faulty_sync_line.h"
#include "hal/fault/faulty_trigger_line.h"
#include "hal/sim/simulated_trigger_line.h"
#include "tests/contracts/clock_contract.h"
#include "tests/contracts/expect.h"
#include "tests/contracts/sync_line_contract.h"

using namespace hdrcam;
using std::chrono::milliseconds;

namespace {

std::unique_ptr<SyncLine> input(SimulatedWire& wire) { return std::make_unique<SimulatedSyncLine>(wire); }
std::unique_ptr<TriggerLine> output(SimulatedWire& wire) {
  return std::make_unique<SimulatedTriggerLine>(wire);
}

}  // namespace

TEST_CASE("the simulated lines keep the contracts of sync and trigger lines") {
  SimulatedWire wire{SimTime()};
  keeps_input_line_contract({.name = "simulated",
                             .open = [&]() -> Result<std::unique_ptr<SyncLine>> { return input(wire); },
                             .drive = [&](bool active) { wire.drive(active); }});
  keeps_output_line_contract({.name = "simulated",
                              .open = [&]() -> Result<std::unique_ptr<TriggerLine>> { return output(wire); },
                              .level = [&] { return wire.level(); }});
}

TEST_CASE("the faulty lines without faults keep the contracts of sync and trigger lines") {
  SimulatedWire wire{SimTime()};
  keeps_input_line_contract({.name = "faulty",
                             .open = [&]() -> Result<std::unique_ptr<SyncLine>> {
                               return std::unique_ptr<SyncLine>(
                                   std::make_unique<FaultySyncLine>(input(wire), std::vector<LineFault>{}));
                             },
                             .drive = [&](bool active) { wire.drive(active); }});
  keeps_output_line_contract({.name = "faulty",
                              .open = [&]() -> Result<std::unique_ptr<TriggerLine>> {
                                return std::unique_ptr<TriggerLine>(std::make_unique<FaultyTriggerLine>(
                                    output(wire), std::vector<TriggerFault>{}, posix_clock()));
                              },
                              .level = [&] { return wire.level(); }});
}

TEST_CASE("the virtual clock keeps the clock contract") {
  VirtualClock clock;
  keeps_clock_contract({.name = "virtual", .clock = clock, .stamp = [&](ClockDomain domain) {
                          return clock.now().since_boot + (domain == ClockDomain::Realtime
                                                               ? VirtualClock::kRealtimeStart
                                                               : Duration::zero());
                        }});
}

TEST_CASE("virtual time passes only while somebody waits") {
  VirtualClock clock;
  SimulatedWire wire{SimTime(clock)};
  SimulatedSyncLine input(wire);
  const Instant begin = clock.now();
  wire.strobe(begin + milliseconds(3), milliseconds(2));
  CHECK(value_of(input.wait_edge(milliseconds(10))).at == begin + milliseconds(3));
  CHECK(clock.now() == begin + milliseconds(3));
  require_error(input.wait_edge(milliseconds(1)), ErrorCode::Timeout);
  CHECK(clock.now() == begin + milliseconds(4));
  CHECK(value_of(input.wait_edge(milliseconds(1))).at == begin + milliseconds(5));
}

TEST_CASE("a reader that is too far behind loses the oldest edges and sees that by their numbers") {
  VirtualClock clock;
  SimulatedWire wire{SimTime(clock)};
  SimulatedSyncLine input(wire);
  for (int i = 0; i < 300; ++i) wire.drive(i % 2 == 0);
  CHECK(value_of(input.wait_edge(Duration::zero())).sequence == 300 - 256);
}

TEST_CASE("what drives a wire is an edge for those who listen, at the instant that the driver is told") {
  VirtualClock clock;
  SimulatedWire wire{SimTime(clock)};
  SimulatedTriggerLine trigger(wire);
  SimulatedSyncLine seen(wire);
  int heard = 0;
  wire.listen([&](const Edge& edge) { heard += edge.rising ? 1 : 10; });
  const DrivenEdge rise = value_of(trigger.drive(LineLevel::Active));
  clock.sleep_until(rise.at + milliseconds(7));
  const DrivenEdge fall = value_of(trigger.drive(LineLevel::Inactive));
  CHECK(value_of(seen.wait_edge(Duration::zero())).at == rise.at);
  CHECK(value_of(seen.wait_edge(Duration::zero())).at == fall.at);
  CHECK(fall.at - rise.at == milliseconds(7));
  CHECK(heard == 11);
}

TEST_CASE("the faulty trigger line fails where it was told to") {
  VirtualClock clock;
  SimulatedWire wire{SimTime(clock)};
  SimulatedSyncLine seen(wire);
  FaultyTriggerLine line(output(wire),
                         {{1, TriggerFaultKind::Unseen},
                          {2, TriggerFaultKind::Late},
                          {3, TriggerFaultKind::Long},
                          {4, TriggerFaultKind::Unplug}},
                         clock);
  std::vector<Duration> told;  // of leading and trailing edges, since the pulse was due
  for (int i = 0; i < 4; ++i) {
    const Instant due = clock.now();
    told.push_back(value_of(line.drive(LineLevel::Active)).at - due);
    told.push_back(value_of(line.drive(LineLevel::Inactive)).at - due);
  }
  const Duration none{0}, late = FaultyTriggerLine::kDelay;
  CHECK(told == std::vector{none, none, none, none, late, late, none, late});
  for (int i = 0; i < 6; ++i) CHECK(seen.wait_edge(Duration::zero()).ok());
  require_error(seen.wait_edge(Duration::zero()), ErrorCode::Timeout);
  require_error(line.drive(LineLevel::Active), ErrorCode::Unplugged);
  require_error(line.drive(LineLevel::Inactive), ErrorCode::Unplugged);
}

TEST_CASE("the faulty sync line fails where it was told to") {
  VirtualClock clock;
  SimulatedWire wire{SimTime(clock)};
  const auto faulty = [&](LineFaultKind kind) {
    auto wrapped = std::make_unique<FaultySyncLine>(input(wire), std::vector<LineFault>{{2, kind}});
    for (int i = 0; i < 4; ++i) wire.strobe(clock.now() + milliseconds(i), std::chrono::microseconds(200));
    for (int i = 0; i < 2; ++i) value_of(wrapped->wait_edge(milliseconds(10)));
    return wrapped;
  };
  const Duration patience = milliseconds(10);
  {
    const auto lost = faulty(LineFaultKind::Lost);
    CHECK(value_of(lost->wait_edge(patience)).sequence == 3);
  }
  {
    const auto unseen = faulty(LineFaultKind::Unseen);
    const Edge edge = value_of(unseen->wait_edge(patience));
    CHECK(edge.sequence == 2);
    CHECK_FALSE(edge.rising);
  }
  {
    const auto spurious = faulty(LineFaultKind::Spurious);
    const Edge edge = value_of(spurious->wait_edge(patience)), twin = value_of(spurious->wait_edge(patience));
    CHECK(twin.at - edge.at == std::chrono::microseconds(1));
    CHECK(twin.sequence == 3);
    CHECK(value_of(spurious->wait_edge(patience)).sequence == 4);
  }
  {
    const auto late = faulty(LineFaultKind::Late);
    const Edge edge = value_of(late->wait_edge(patience)), next = value_of(late->wait_edge(patience));
    CHECK(edge.at > next.at);
  }
  {
    const auto timeout = faulty(LineFaultKind::Timeout);
    require_error(timeout->wait_edge(patience), ErrorCode::Timeout);
    CHECK(value_of(timeout->wait_edge(patience)).sequence == 2);
  }
  {
    const auto unplug = faulty(LineFaultKind::Unplug);
    require_error(unplug->wait_edge(patience), ErrorCode::Unplugged);
    require_error(unplug->wait_edge(patience), ErrorCode::Unplugged);
  }
}
