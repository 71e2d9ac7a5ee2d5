#include "capture/order_check.h"

#include <cmath>

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

const double kShort = std::log(1.0), kMiddle = std::log(4.0), kLong = std::log(16.0);  // ln E

// What pictures say of the step to a later frame, as ln of their ratio.
CycleStep seen(double log_ratio) { return {StepKind::Measured, log_ratio, 0}; }

TEST_CASE("pictures contradict an order where they clearly go up and it clearly goes down, or the reverse",
          "[capture]") {
  OrderCheck order(1);
  CHECK_FALSE(order.add(kShort, kMiddle, seen(1.4)));
  CHECK_FALSE(order.add(kMiddle, kShort, seen(-1.4)));
  CHECK(order.add(kShort, kMiddle, seen(-0.4)));
  CHECK(order.add(kMiddle, kShort, seen(0.4)));
  CHECK_FALSE(order.add(kShort, kMiddle, seen(-0.2)));     // hardly seen
  CHECK_FALSE(order.add(kShort, kShort + 0.4, seen(-2)));  // hardly said
  CHECK_FALSE(order.add(kShort, kShort, seen(2)));         // a lamp between two equal exposures
}

TEST_CASE("an order is objected to where one of its steps is contradicted more often than not", "[capture]") {
  OrderCheck order(3);
  const auto add = [&](int times, double from, double to, double log_ratio) {
    for (int i = 0; i < times; ++i) order.add(from, to, seen(log_ratio));
  };
  add(2, kShort, kMiddle, -1);
  add(2, kMiddle, kLong, -1);
  CHECK_FALSE(order.objects());  // too few of either
  add(1, kShort, kMiddle, -1);
  CHECK(order.objects());
  add(3, kShort, kMiddle, 1);
  CHECK_FALSE(order.objects());               // three of six
  add(1, kShort + 0.04, kMiddle - 0.04, -1);  // exposures jitter
  CHECK(order.objects());
  add(10, kMiddle, kLong, 1);  // what other steps say does not help it
  CHECK(order.objects());
}

TEST_CASE("more kinds of steps than a cycle has are not counted, and those that are stay", "[capture]") {
  constexpr int kCounted = 16;
  OrderCheck order(2);
  for (int i = 0; i < 2 * kCounted; ++i) CHECK(order.add(i, i + 1, seen(-1)));
  for (int i = kCounted; i < 2 * kCounted; ++i) CHECK(order.add(i, i + 1, seen(-1)));
  CHECK_FALSE(order.objects());
  CHECK(order.add(kCounted - 1, kCounted, seen(-1)));
  CHECK(order.objects());
}

}  // namespace
}  // namespace hdrcam
