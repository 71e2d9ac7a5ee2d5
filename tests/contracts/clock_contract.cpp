#include "tests/contracts/clock_contract.h"
#include "tests/allocation_checks.h"

#include <chrono>

#include "tests/contracts/expect.h"

namespace hdrcam {
namespace {

using std::chrono::milliseconds;

void never_runs_backwards(const ClockUnderTest& facts) {
  Instant before = facts.clock.now();
  for (int i = 0; i < 1000; ++i) {
    const Instant now = facts.clock.now();
    REQUIRE(now >= before);
    before = now;
  }
}

void sleeps_until_the_instant(const ClockUnderTest& facts) {
  const Instant wanted = facts.clock.now() + milliseconds(5);
  facts.clock.sleep_until(wanted);
  CHECK(facts.clock.now() >= wanted);
  const Instant before = facts.clock.now();
  facts.clock.sleep_until(Instant{before.since_boot - std::chrono::hours(1)});  // the past is no wait
  CHECK(facts.clock.now() - before < std::chrono::seconds(1));
}

void converts_other_clocks(const ClockUnderTest& facts) {
  for (const ClockDomain domain : {ClockDomain::Boot, ClockDomain::Monotonic, ClockDomain::Realtime}) {
    INFO("domain " << static_cast<int>(domain));
    const Instant before = facts.clock.now();
    const Instant converted = facts.clock.instant_of(domain, facts.stamp(domain));
    const Instant after = facts.clock.now();
    CHECK(converted >= Instant{before.since_boot - facts.tolerance});
    CHECK(converted <= after + facts.tolerance);
  }
}

void keeps_intervals(const ClockUnderTest& facts) {
  for (const ClockDomain domain : {ClockDomain::Boot, ClockDomain::Monotonic}) {
    const Duration stamp = facts.stamp(domain);
    const Instant first = facts.clock.instant_of(domain, stamp - milliseconds(100));
    const Instant second = facts.clock.instant_of(domain, stamp);
    CHECK(second - first == milliseconds(100));
  }
}

void does_not_allocate(const ClockUnderTest& facts) {
  const Duration stamp = facts.stamp(ClockDomain::Monotonic);
  (void)facts.clock.instant_of(ClockDomain::Monotonic, stamp);
  const std::uint64_t before = allocations_so_far();
  (void)facts.clock.now();
  (void)facts.clock.instant_of(ClockDomain::Monotonic, stamp);
  CHECK_ALLOCATIONS(allocations_so_far() == before);
}

struct Clause {
  const char* sentence;
  void (*holds)(const ClockUnderTest&);
};
constexpr Clause kClauses[] = {
    {"never runs backwards", never_runs_backwards},
    {"sleeps until the instant and not before", sleeps_until_the_instant},
    {"converts stamps of other clocks", converts_other_clocks},
    {"keeps the interval between two stamps of one clock", keeps_intervals},
    {"does not allocate", does_not_allocate},
};

}  // namespace

void keeps_clock_contract(const ClockUnderTest& clock) {
  for (const Clause& clause : kClauses) DYNAMIC_SECTION(clock.name << " " << clause.sentence) {
      clause.holds(clock);
    }
}

}  // namespace hdrcam
