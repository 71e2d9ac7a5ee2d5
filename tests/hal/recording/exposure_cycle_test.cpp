#include "hal/recording/exposure_cycle.h"

#include <cmath>
#include <random>

#include "tests/allocation_checks.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

std::vector<FrameFacts> frames_of(const std::vector<double>& exposures_s) {
  std::vector<FrameFacts> frames(exposures_s.size());
  for (std::size_t i = 0; i < frames.size(); ++i)
    frames[i].sequence = 100 + i, frames[i].exposure_s = exposures_s[i];
  return frames;
}

std::vector<FrameFacts> repeated(const std::vector<double>& cycle_ev, std::size_t count,
                                 double jitter_ev = 0) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> jitter(-jitter_ev, jitter_ev);
  std::vector<double> exposures;
  for (std::size_t i = 0; i < count; ++i)
    exposures.push_back(0.004 * std::exp2(cycle_ev[i % cycle_ev.size()] + jitter(random)));
  return frames_of(exposures);
}

int period_of(const std::vector<FrameFacts>& frames) { return find_exposure_cycle(frames).period; }

}  // namespace

TEST_CASE("the period of a schedule is the shortest that repeats") {
  CHECK(period_of(repeated({0}, 2)) == 1);
  CHECK(period_of(repeated({-2, 2}, 20)) == 2);
  CHECK(period_of(repeated({-2, 0, 2}, 48)) == 3);
  CHECK(period_of(repeated({-2, 0, 2, 0}, 48)) == 4);
  CHECK(period_of(repeated({-2, -2, 2}, 9)) == 3);
  CHECK(period_of(repeated({-3, -1, 1, 3, 0}, 11)) == 5);
}

TEST_CASE("the exposures of the slots are their geometric means") {
  const auto cycle = find_exposure_cycle(frames_of({0.001, 0.016, 0.0011, 0.016}));
  REQUIRE(cycle.period == 2);
  CHECK(cycle.exposures[0] == Approx(std::sqrt(0.001 * 0.0011)));
  CHECK(cycle.exposures[1] == Approx(0.016));
}

TEST_CASE("exposures that wander a little keep their slots, those that wander more do not") {
  CHECK(period_of(repeated({-2, 0, 2}, 30, 0.15)) == 3);
  CHECK(period_of(repeated({-2, 0, 2}, 30, 0.9)) == 0);
  CHECK(period_of(repeated({-0.2, 0.2}, 30)) == 1);
}

TEST_CASE("what was not seen twice does not repeat") {
  CHECK(period_of({}) == 0);
  CHECK(period_of(repeated({0}, 1)) == 0);
  CHECK(period_of(repeated({-2, 2}, 2)) == 0);
  CHECK(period_of(repeated({-2, 0, 2}, 5)) == 0);
  CHECK(period_of(repeated({-2, 0, 2}, 6)) == 3);
  CHECK(slot_of({}, {}, {}) == -1);
}

TEST_CASE("a slow change of exposure is no schedule") {
  std::vector<double> exposures;
  for (int i = 0; i < 60; ++i) exposures.push_back(0.001 * std::exp2(i * 0.05));
  CHECK(period_of(frames_of(exposures)) == 0);
}

TEST_CASE("dropped frames do not shift the slots") {
  auto frames = repeated({-2, 0, 2}, 30);
  frames.erase(frames.begin() + 4, frames.begin() + 6);
  frames.erase(frames.begin() + 11);
  const auto cycle = find_exposure_cycle(frames);
  REQUIRE(cycle.period == 3);
  for (const FrameFacts& frame : frames) {
    const int slot = slot_of(cycle, frames.front(), frame);
    CHECK(frame.exposure() == Approx(cycle.exposures[static_cast<std::size_t>(slot)]));
  }
}

TEST_CASE("exposures that cannot be take no part in the search") {
  auto frames = repeated({-2, 0, 2}, 30);
  frames[7].exposure_s = 0;
  frames[8].exposure_s = std::nan("");
  CHECK(period_of(frames) == 3);
  frames[20].sequence = 3;  // runs backwards
  CHECK(period_of(frames) == 0);
}

TEST_CASE("slots that the frames say themselves are the cycle, whatever came before it began") {
  auto frames = frames_of({0.004, 0.004, 0.001, 0.016, 0.001, 0.016});
  CHECK(find_exposure_cycle(frames).period == 0);
  for (std::size_t i = 2; i < frames.size(); ++i) frames[i].slot = static_cast<int>((i + 1) % 2);
  const auto cycle = find_exposure_cycle(frames);
  REQUIRE(cycle.period == 2);
  CHECK(cycle.recorded);
  CHECK(cycle.exposures[0] == Approx(0.016));
  CHECK(slot_of(cycle, frames.front(), frames[0]) == -1);
  CHECK(slot_of(cycle, frames.front(), frames[2]) == 1);
  frames[3].exposure_s = 0.001;  // says slot 0, but is not
  CHECK_FALSE(find_exposure_cycle(frames).recorded);
}

TEST_CASE("frames that come one by one show the cycle as soon as it repeats, and none of them is kept") {
  const auto frames = repeated({-2, 0, 2}, 600);
  ExposureCycleSearch search;
  for (std::size_t i = 0; i < 5; ++i) search.add(frames[i]);
  CHECK(search.cycle().period == 0);
  const std::uint64_t before = own_allocations_so_far();
  for (std::size_t i = 5; i < frames.size(); ++i) search.add(frames[i]);
  CHECK_ALLOCATIONS(own_allocations_so_far() == before);
  REQUIRE(search.cycle().period == 3);
  CHECK(search.cycle().exposures[0] == Approx(0.001));
  CHECK(search.cycle().exposures[2] == Approx(0.016));
}
