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

}  // namespace
}  // namespace hdrcam
