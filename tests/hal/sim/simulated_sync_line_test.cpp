#include "hal/sim/simulated_sync_line.h"

#include "hal/fault/faulty_sync_line.h"
#include "tests/contracts/clock_contract.h"
#include "tests/contracts/expect.h"
#include "tests/contracts/sync_line_contract.h"

using namespace hdrcam;
using std::chrono::milliseconds;

namespace {

std::unique_ptr<SyncLine> line(SimulatedWire& wire, LineDirection direction) {
  return std::make_unique<SimulatedSyncLine>(wire, direction);
}

}  // namespace

TEST_CASE("the simulated sync line keeps the sync line contract") {
  SimulatedWire wire{SimTime()};
  keeps_input_line_contract(
      {.name = "simulated",
       .open = [&]() -> Result<std::unique_ptr<SyncLine>> { return line(wire, LineDirection::Input); },
       .drive = [&](bool active) { wire.drive(active); }});
  keeps_output_line_contract(
      {.name = "simulated",
       .open = [&]() -> Result<std::unique_ptr<SyncLine>> { return line(wire, LineDirection::Output); },
       .level = [&] { return wire.level(); }});
}

TEST_CASE("the faulty sync line without faults keeps the sync line contract") {
  SimulatedWire wire{SimTime()};
  const auto open = [&](LineDirection direction) -> Result<std::unique_ptr<SyncLine>> {
    return std::unique_ptr<SyncLine>(
        std::make_unique<FaultySyncLine>(line(wire, direction), std::vector<LineFault>{}));
  };
  keeps_input_line_contract({.name = "faulty",
                             .open = [&] { return open(LineDirection::Input); },
                             .drive = [&](bool active) { wire.drive(active); }});
  keeps_output_line_contract({.name = "faulty",
                              .open = [&] { return open(LineDirection::Output); },
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
  SimulatedSyncLine input(wire, LineDirection::Input);
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
  SimulatedSyncLine input(wire, LineDirection::Input);
  for (int i = 0; i < 300; ++i) wire.drive(i % 2 == 0);
  CHECK(value_of(input.wait_edge(Duration::zero())).sequence == 300 - 256);
}

TEST_CASE("an output's pulses are an input's edges") {
  VirtualClock clock;
  SimulatedWire wire{SimTime(clock)};
  SimulatedSyncLine output(wire, LineDirection::Output), input(wire, LineDirection::Input);
  require_done(output.pulse(milliseconds(7)));
  const Edge rise = value_of(input.wait_edge(Duration::zero())),
             fall = value_of(input.wait_edge(Duration::zero()));
  CHECK(rise.rising);
  CHECK_FALSE(fall.rising);
  CHECK(fall.at - rise.at == milliseconds(7));
}

TEST_CASE("the faulty sync line fails where it was told to") {
  VirtualClock clock;
  SimulatedWire wire{SimTime(clock)};
  const auto faulty = [&](LineFaultKind kind) {
    auto wrapped =
        std::make_unique<FaultySyncLine>(line(wire, LineDirection::Input), std::vector<LineFault>{{2, kind}});
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
