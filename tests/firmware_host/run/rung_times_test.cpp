#include "firmware_host/run/rung_times.h"

#include <vector>

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

FrameWork work(double total_ms, double steady_ms = 1) {
  return {.frames = 1, .total_ms = total_ms, .steady_ms = steady_ms};
}

// Of frames that are emitted one by one.
RungTimes times_of(const std::vector<double>& totals_ms) {
  RungTimes times;
  for (const double total_ms : totals_ms) times.add(work(total_ms), 1);
  return times;
}

TEST_CASE("frames that share an emission count once, as their mean") {
  RungTimes times;
  CHECK_FALSE(times.add(work(10, 4), 2));
  CHECK(times.count() == 0);
  const auto both = times.add(work(20, 6), 2);
  REQUIRE(both);
  CHECK(both->total_ms == Approx(15));
  CHECK(both->steady_ms == Approx(5));
  CHECK(times.count() == 1);
}

TEST_CASE("of a rung that has just come into use the first time does not count, nor half an emission") {
  RungTimes times = times_of({50, 50, 50});
  CHECK_FALSE(times.add(work(1000), 2));
  times.restart();
  CHECK(times.count() == 0);
  CHECK_FALSE(times.add(work(10), 2));
  const auto first = times.add(work(20), 2);
  REQUIRE(first);
  CHECK(first->total_ms == Approx(15));  // without the frame from before
  CHECK(times.count() == 0);
  times.add(work(30), 1);
  CHECK(times.count() == 1);
  CHECK(times.usual().total_ms == Approx(30));
}

TEST_CASE("where each frame has to be in time, two outliers of the newest eight do not count, three do") {
  CHECK(times_of({10, 100, 10, 10, 10, 100, 10, 10}).usual().total_ms == Approx(10));
  CHECK(times_of({10, 100, 10, 10, 100, 100, 10, 10}).usual().total_ms == Approx(100));
  const RungTimes newest = times_of({100, 100, 3, 4, 5, 6, 7, 8, 9, 10});
  CHECK(newest.is_full());
  CHECK(newest.usual().total_ms == Approx(8));
  CHECK(newest.upper_quartile(4).total_ms == Approx(9));
  CHECK(newest.upper_quartile(100).total_ms == Approx(8));
  CHECK_FALSE(times_of({1, 2, 3, 4, 5, 6, 7}).is_full());
}

TEST_CASE("where frames queue their mean counts, and the longest no more than the second longest") {
  for (const std::vector<int>& order : {std::vector<int>{0, 1, 2}, {2, 0, 1}, {1, 2, 0}}) {
    const FrameWork frames[] = {work(10, 2), work(30, 3), work(60, 6)};
    RungTimes times;
    times.set_frames_queue(true);
    for (const int frame : order) times.add(frames[frame], 1);
    CAPTURE(order);
    CHECK(times.usual().total_ms == Approx((10 + 30 + 30) / 3.0));
    CHECK(times.steady_ms() == Approx((2 + 3 + 3) / 3.0));
    CHECK(times.ratio() == Approx(70 / 8.0));
    times.set_frames_queue(false);
    CHECK(times.usual().total_ms == Approx(30));
    CHECK(times.steady_ms() == Approx(3));
    CHECK(times.ratio() == Approx(10));  // of 5, 10 and 10
  }
}

TEST_CASE("a frame without steady work has a ratio all the same") {
  RungTimes times;
  times.add(work(5, 0), 1);
  CHECK(times.ratio() == Approx(5000));
}

}  // namespace
}  // namespace hdrcam
