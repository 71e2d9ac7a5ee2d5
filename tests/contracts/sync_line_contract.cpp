#include "tests/contracts/sync_line_contract.h"

#include <chrono>
#include <thread>
#include <utility>

#include "tests/allocation_checks.h"
#include "tests/contracts/expect.h"

namespace hdrcam {
namespace {

using std::chrono::milliseconds;

void sees_edges_in_order(const InputLineUnderTest& facts) {
  facts.drive(false);
  auto line = value_of(facts.open());
  Edge before{};
  for (int i = 0; i < 20; ++i) {
    facts.drive(i % 2 == 0);
    const Edge edge = value_of(line->wait_edge(facts.patience));
    INFO("edge " << i);
    REQUIRE(edge.rising == (i % 2 == 0));
    if (i > 0) {
      REQUIRE(edge.sequence == before.sequence + 1);
      REQUIRE(edge.at > before.at);
    }
    before = edge;
  }
  facts.drive(false);
}

void does_not_allocate_per_edge(const InputLineUnderTest& facts) {
  facts.drive(false);
  auto line = value_of(facts.open());
  std::uint64_t in_waits = 0;
  for (int i = 0; i < 20; ++i) {
    facts.drive(i % 2 == 0);
    const std::uint64_t before = allocations_so_far();
    const bool came = line->wait_edge(facts.patience).ok();
    if (i > 1) in_waits += allocations_so_far() - before;
    REQUIRE(came);
  }
  CHECK_ALLOCATIONS(in_waits == 0);
}

void times_out_without_an_edge(const InputLineUnderTest& facts) {
  facts.drive(false);
  auto line = value_of(facts.open());
  require_error(line->wait_edge(milliseconds(30)), ErrorCode::Timeout);
  facts.drive(true);
  CHECK(value_of(line->wait_edge(facts.patience)).rising);
  facts.drive(false);
}

void ends_a_wait_by_close(const InputLineUnderTest& facts) {
  auto line = value_of(facts.open());
  std::thread other([&] {
    std::this_thread::sleep_for(milliseconds(50));
    line->close();
  });
  const Result<Edge> waited = line->wait_edge(std::chrono::seconds(20));
  other.join();
  require_error(waited, ErrorCode::Interrupted);
  require_error(line->wait_edge(milliseconds(1)), ErrorCode::Interrupted);
  line->close();  // once more is no harm
}

void sets_the_level(const OutputLineUnderTest& facts) {
  auto line = value_of(facts.open());
  CHECK_FALSE(line->name().empty());
  CHECK_FALSE(facts.level());
  Instant before;
  for (const LineLevel level :
       {LineLevel::Active, LineLevel::Inactive, LineLevel::Active, LineLevel::Active, LineLevel::Inactive}) {
    const DrivenEdge edge = value_of(line->drive(level));
    CHECK(facts.level() == (level == LineLevel::Active));
    CHECK(edge.within >= Duration::zero());
    CHECK(edge.at >= before);
    before = edge.at;
  }
}

void is_left_inactive(const OutputLineUnderTest& facts) {
  {
    auto line = value_of(facts.open());
    value_of(line->drive(LineLevel::Active));
    CHECK(facts.level());
  }
  CHECK_FALSE(facts.level());
  CHECK(facts.open().ok());  // and free again
}

template <class Line>
struct Clause {
  const char* sentence;
  void (*holds)(const Line&);
};
constexpr Clause<InputLineUnderTest> kInputClauses[] = {
    {"sees every edge in order, stamped", sees_edges_in_order},
    {"does not allocate per edge", does_not_allocate_per_edge},
    {"times out when no edge comes", times_out_without_an_edge},
    {"ends a wait when another thread closes it", ends_a_wait_by_close},
};
constexpr Clause<OutputLineUnderTest> kOutputClauses[] = {
    {"has the level that it was set to", sets_the_level},
    {"is left inactive", is_left_inactive},
};

}  // namespace

void keeps_input_line_contract(const InputLineUnderTest& line) {
  for (const auto& clause : kInputClauses) DYNAMIC_SECTION(line.name << " " << clause.sentence) {
      clause.holds(line);
    }
}

void keeps_output_line_contract(const OutputLineUnderTest& line) {
  for (const auto& clause : kOutputClauses) DYNAMIC_SECTION(line.name << " " << clause.sentence) {
      clause.holds(line);
    }
}

}  // namespace hdrcam
