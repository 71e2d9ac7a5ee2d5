#include "capture/edge_errors.h"

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

using namespace std::chrono_literals;

TEST_CASE("the errors of edges are summed up as mean, 99th percentile and the worst") {
  EdgeErrors errors;
  for (int i = 1; i <= 1000; ++i) errors.add(std::chrono::microseconds(i % 2 == 0 ? i : -i));
  CHECK(errors.count() == 1000);
  CHECK(to_seconds(errors.mean()) == Approx(500.5e-6));
  CHECK(errors.p99() >= 990us);
  CHECK(errors.p99() <= 1000us);
  CHECK(errors.most() == 1000us);
  EdgeErrors outlier;
  for (int i = 0; i < 999; ++i) outlier.add(10us);
  outlier.add(50ms);
  CHECK(outlier.p99() >= 10us);
  CHECK(outlier.p99() <= 12us);
  CHECK(outlier.most() == 50ms);
}

TEST_CASE("99 of 100 edges are as near as is said, which is at most a fifth too much, from microseconds on") {
  for (const Duration usual :
       {Duration(1us), Duration(1500ns), Duration(10us), Duration(333us), Duration(7ms), Duration(2s)}) {
    EdgeErrors errors;
    for (int i = 0; i < 995; ++i) errors.add(usual);
    for (int i = 0; i < 5; ++i) errors.add(100 * usual);
    CAPTURE(usual.count());
    CHECK(errors.p99() >= usual);
    CHECK(to_seconds(errors.p99()) <= 1.19 * to_seconds(usual));
    CHECK(errors.most() == 100 * usual);
  }
}

TEST_CASE("without an edge there is no error") {
  const EdgeErrors none;
  CHECK(none.count() == 0);
  CHECK(none.mean() == 0s);
  CHECK(none.p99() == 0s);
  CHECK(none.most() == 0s);
}

}  // namespace
}  // namespace hdrcam
