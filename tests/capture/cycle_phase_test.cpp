#include "capture/cycle_phase.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;

namespace {

Exposure exposure_of(double ms) { return {from_seconds(ms * 1e-3), 1}; }

struct Footage {
  std::vector<int> slots;  // the truth
  std::vector<CycleStep> steps;
};

// Frames of a cycle from slot `first` on; before the frames of `losses` so many are missing. A measured ratio
// is stretched and has an error of a tenth of it and .05.
Footage footage(const std::vector<Exposure>& cycle, int frames, int first,
                const std::vector<std::pair<int, int>>& losses, double stretch, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Footage made;
  int slot = first;
  const auto n = static_cast<int>(cycle.size());
  for (int i = 0; i < frames; ++i) {
    for (const auto& [frame, lost] : losses)
      if (frame == i) slot += lost;
    made.slots.push_back(slot++ % n);
    if (i == 0) continue;
    const double ratio = log_product(cycle[static_cast<std::size_t>(made.slots.back())]) -
                         log_product(cycle[static_cast<std::size_t>(made.slots[made.slots.size() - 2])]);
    const double error = (0.1 * std::abs(ratio) + 0.05) * normal(random);
    made.steps.push_back({StepKind::Measured, stretch * ratio + error, 0});
  }
  return made;
}

// What pictures say of such frames over one to four of them, with an error of `least` and a tenth of the
// ratio.
StepsByLag steps_by_lag(const std::vector<Exposure>& cycle, const std::vector<int>& slots, double stretch,
                        double least) {
  StepsByLag steps(4);
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  for (std::size_t lag = 1; lag <= 4; ++lag)
    for (std::size_t i = 0; i + lag < slots.size(); ++i) {
      const double ratio = stretch * (log_product(cycle[static_cast<std::size_t>(slots[i + lag])]) -
                                      log_product(cycle[static_cast<std::size_t>(slots[i])]));
      const double error = (0.1 * std::abs(ratio) + least) * normal(random);
      steps[lag - 1].push_back({StepKind::Measured, ratio + error, 0});
    }
  return steps;
}

// Whether each frame is given its exposure, all of them by one factor off.
void check_exposures(const std::vector<Exposure>& found, const std::vector<int>& found_slots,
                     const std::vector<Exposure>& truth, const std::vector<int>& slots, double margin) {
  // The cycle may begin with another of its exposures.
  const auto offset = [&](std::size_t i) {
    return log_product(found[static_cast<std::size_t>(found_slots[i])]) -
           log_product(truth[static_cast<std::size_t>(slots[i])]);
  };
  REQUIRE(found_slots.size() == slots.size());
  for (std::size_t i = 0; i < slots.size(); ++i) CHECK(offset(i) == Approx(offset(0)).margin(margin));
}

const std::vector<std::vector<Exposure>> kCycles{
    {exposure_of(1), exposure_of(4)},
    {exposure_of(1), exposure_of(4), exposure_of(16)},
    {exposure_of(16), exposure_of(1), exposure_of(4)},
    {exposure_of(1), exposure_of(2), exposure_of(4), exposure_of(8)},
};

}  // namespace

TEST_CASE("the phase of a cycle is found whatever frame the footage begins with, and whatever the response") {
  for (const auto& cycle : kCycles)
    for (int first = 0; first < static_cast<int>(cycle.size()); ++first)
      for (const double stretch : {0.45, 0.7, 1.0, 1.6}) {
        const Footage made = footage(cycle, 30, first, {}, stretch, 7);
        const auto walk = find_walk(made.steps, cycle);
        INFO(cycle.size() << " exposures from " << first << ", stretch " << stretch);
        REQUIRE(walk.ok());
        CHECK(walk.value().slots == made.slots);
        CHECK(walk.value().stretch == Approx(stretch).epsilon(0.25));
        CHECK(walk.value().measured == 29);
        for (const int lost : walk.value().lost_before) CHECK(lost == 0);
      }
}

TEST_CASE("two frames of a cycle in even steps do not tell its phase; those over its largest step do") {
  const auto& cycle = kCycles[1];
  const Footage longer = footage(cycle, 12, 0, {}, 1, 7);
  CHECK_FALSE(find_walk(longer.steps, cycle).value().ambiguous);
  const std::vector<CycleStep> even{{StepKind::Measured, std::log(4.), 0}};
  CHECK(find_walk(even, cycle).value().ambiguous);
  const std::vector<CycleStep> down{{StepKind::Measured, -std::log(16.), 0}};
  CHECK_FALSE(find_walk(down, cycle).value().ambiguous);
}

TEST_CASE("frames that are missing inside are found where they are missing") {
  const auto& cycle = kCycles[1];
  const Footage made = footage(cycle, 60, 1, {{13, 1}, {30, 2}, {41, 1}}, 0.7, 11);
  const auto walk = find_walk(made.steps, cycle);
  REQUIRE(walk.ok());
  CHECK(walk.value().slots == made.slots);
  for (int i = 0; i < 60; ++i)
    CHECK(walk.value().lost_before[static_cast<std::size_t>(i)] == (i == 30              ? 2
                                                                    : i == 13 || i == 41 ? 1
                                                                                         : 0));
}

TEST_CASE("a loss that the times tell may be a whole round of the cycle, which no picture shows") {
  const auto& cycle = kCycles[1];
  Footage made = footage(cycle, 24, 0, {{9, 3}, {15, 1}}, 1, 3);
  made.steps[8].missing = 3;
  made.steps[14].missing = 1;
  const auto walk = find_walk(made.steps, cycle);
  REQUIRE(walk.ok());
  CHECK(walk.value().slots == made.slots);
  CHECK(walk.value().lost_before[9] == 3);
  CHECK(walk.value().lost_before[15] == 1);
}

TEST_CASE("a frame that comes late is no loss of a whole round where the pictures go on with the cycle") {
  for (const auto& cycle : {kCycles[0], kCycles[1]}) {
    Footage made = footage(cycle, 24, 0, {}, 1, 3);
    for (const std::size_t step : {5u, 11u, 17u}) made.steps[step].missing = 1;  // two intervals, by its time
    made.steps[20].missing = 2;                                                  // three
    const auto walk = find_walk(made.steps, cycle);
    REQUIRE(walk.ok());
    CHECK(walk.value().slots == made.slots);
    for (int i = 0; i < 24; ++i)
      CHECK(walk.value().lost_before[static_cast<std::size_t>(i)] ==
            (i == 21 ? static_cast<int>(cycle.size()) : 0));
  }
}

TEST_CASE("a light that is switched on is one odd step, not a loss") {
  const auto& cycle = kCycles[1];
  Footage made = footage(cycle, 40, 0, {}, 1, 5);
  made.steps[19].log_ratio += 1.2;
  const auto walk = find_walk(made.steps, cycle);
  REQUIRE(walk.ok());
  CHECK(walk.value().slots == made.slots);
}

TEST_CASE("pictures that have nothing in common still show who is brighter") {
  const std::vector<Exposure> cycle{exposure_of(0.06), exposure_of(1.8), exposure_of(29)};
  Footage made = footage(cycle, 30, 2, {{12, 1}}, 0.5, 9);
  for (CycleStep& step : made.steps) step.kind = StepKind::Rough;
  const auto walk = find_walk(made.steps, cycle);
  REQUIRE(walk.ok());
  CHECK(walk.value().slots == made.slots);
  CHECK(walk.value().measured == 0);
}

TEST_CASE(
    "exposures in another order than the camera's are refused, also where pictures have nothing in common") {
  // what is known of such a step is compressed: black and clipped parts do not change
  const std::vector<std::vector<double>> cycles{{0.6187, 3.649, 18.99}, {0.05625, 1.8, 28.8}, {1, 4, 16, 64}};
  for (const std::vector<double>& times_ms : cycles)
    for (const double stretch : {0.4, 0.6, 1.0}) {
      std::vector<Exposure> cycle;
      for (const double ms : times_ms) cycle.push_back(exposure_of(ms));
      Footage made = footage(cycle, 30, 1, {}, stretch, 9);
      for (CycleStep& step : made.steps) {
        step.kind = StepKind::Rough;
        step.log_ratio = 1.6 * std::tanh(step.log_ratio / 1.6);
      }
      std::vector<std::size_t> order(cycle.size());
      std::iota(order.begin(), order.end(), std::size_t{0});
      do {
        std::vector<Exposure> said;
        for (const std::size_t slot : order) said.push_back(cycle[slot]);
        const auto begin = std::ranges::find(order, std::size_t{0}) - order.begin();
        bool is_rotation = true;
        for (std::size_t i = 0; i < order.size(); ++i)
          is_rotation &= order[(static_cast<std::size_t>(begin) + i) % order.size()] == i;
        const auto walk = find_walk(made.steps, said);
        CAPTURE(times_ms, stretch, order, is_rotation);
        REQUIRE(walk.ok() == is_rotation);
        if (!is_rotation) CHECK(walk.error().code == ErrorCode::BadExposure);
      } while (std::next_permutation(order.begin(), order.end()));
    }
}

TEST_CASE("of raw pictures that have nothing in common the clipped one is the brighter one, too") {
  constexpr int kBits = 12, kMost = (1 << kBits) - 1;
  const Photometer photometer(PhotometricResponse::linear(BlackLevel(16)));
  const auto picture_of = [&](int code) {
    Image<std::uint16_t> codes(1, 48, 64);
    codes.fill(static_cast<std::uint16_t>(code));
    PhotometricSignature picture;
    photometer.observe(codes, PixelLayout::BayerRggb, kBits, picture);
    return picture;
  };
  const PhotometricSignature dim = picture_of(kMost / 4), bright = picture_of(kMost);
  CHECK(rough_step(dim, bright).log_ratio > 1);
  CHECK(rough_step(bright, dim).log_ratio < -1);
}

TEST_CASE("a right order is right though frames are black") {
  const auto& cycle = kCycles[1];
  for (const std::vector<std::size_t>& black : {std::vector<std::size_t>{5}, {11, 20, 38}})
    for (const int frames : {9, 48}) {
      Footage made = footage(cycle, frames, 0, {}, 0.7, 9);
      for (const std::size_t frame : black) {
        if (frame + 1 >= static_cast<std::size_t>(frames)) continue;
        made.steps[frame - 1] = {StepKind::Rough, -2.5, 0};
        made.steps[frame] = {StepKind::Rough, 1.5, 0};
      }
      CAPTURE(black, frames);
      const auto walk = find_walk(made.steps, cycle);
      REQUIRE(walk.ok());
      CHECK(walk.value().slots == made.slots);
    }
}

TEST_CASE("footage that does not alternate as it is said to is refused") {
  const Footage still = footage({exposure_of(4)}, 30, 0, {}, 1, 5);
  const auto refused = find_walk(still.steps, kCycles[1]);
  REQUIRE_FALSE(refused.ok());
  CHECK(refused.error().code == ErrorCode::BadExposure);
  CHECK_THAT(refused.error().message, Contains("1 ms, 4 ms, 16 ms") && Contains("--shutter auto"));
  CHECK(find_walk(still.steps, {}).error().code == ErrorCode::Invalid);
  const Footage changing = footage(kCycles[1], 30, 0, {}, 1, 5);
  const std::vector<Exposure> one{exposure_of(4)};
  const auto not_one = find_walk(changing.steps, one);
  REQUIRE_FALSE(not_one.ok());
  CHECK(not_one.error().code == ErrorCode::BadExposure);
  CHECK_THAT(not_one.error().message,
             Contains("the exposure changes between frames, and is not always 4 ms"));
}

TEST_CASE("frames that came twice are counted, and neither losses nor frames of one exposure are") {
  const auto& cycle = kCycles[1];
  Footage made = footage(cycle, 24, 0, {}, 0.7, 5);
  CHECK(count_copies(made.steps, cycle) == 0);
  std::vector<CycleStep> doubled;
  for (const CycleStep& step : made.steps) {
    doubled.push_back({StepKind::Measured, 0.01, 0});
    doubled.push_back(step);
  }
  CHECK(count_copies(doubled, cycle) == 23);
  doubled[0].missing = 2;             // a whole round but one, as the times tell
  doubled[2].kind = StepKind::Rough;  // two black frames
  CHECK(count_copies(doubled, cycle) == 21);
  const Footage still = footage({exposure_of(4)}, 24, 0, {}, 1, 5);
  CHECK(count_copies(still.steps, std::vector<Exposure>{exposure_of(4)}) == 0);
  CHECK(count_copies(doubled, std::vector<Exposure>{exposure_of(1), exposure_of(1), exposure_of(8)}) == 0);
}

TEST_CASE("a cycle that nobody knows comes out of the pictures with its ratios, losses or not") {
  for (const auto& cycle : kCycles)
    for (const bool losses : {false, true}) {
      Footage made = footage(
          cycle, 50, 1,
          losses ? std::vector<std::pair<int, int>>{{20, 1}} : std::vector<std::pair<int, int>>{}, 1, 21);
      const StepsByLag steps = steps_by_lag(cycle, made.slots, 1, 0.05);
      const auto found = estimate_cycle(steps);
      REQUIRE(found.ok());
      INFO(cycle.size() << " exposures");
      REQUIRE(found.value().size() == cycle.size());
      const auto walk = find_walk(steps[0], found.value());
      REQUIRE(walk.ok());
      check_exposures(found.value(), walk.value().slots, cycle, made.slots, 0.35);
    }
}

TEST_CASE("a cycle of a third of a stop is found, and one of which some exposures are nearly equal") {
  const std::vector<std::vector<double>> cycles{
      {4, 5}, {4, 4.93, 6.06}, {2, 2.05, 2.1, 8}, {2, 8, 8.2, 8.1}, {2, 2.5, 2, 3.2}};
  for (const std::vector<double>& times_ms : cycles)
    for (const double stretch : {0.65, 1.0}) {
      std::vector<Exposure> cycle;
      for (const double ms : times_ms) cycle.push_back(exposure_of(ms));
      const Footage made = footage(cycle, 24, 0, {}, 1, 7);
      const StepsByLag steps = steps_by_lag(cycle, made.slots, stretch, 0.005);  // as of a moving scene
      CAPTURE(times_ms, stretch);
      const auto found = estimate_cycle(steps);
      REQUIRE(found.ok());
      REQUIRE(found.value().size() == cycle.size());
      const auto walk = find_walk(steps[0], found.value());
      REQUIRE(walk.ok());
      if (stretch == 1) check_exposures(found.value(), walk.value().slots, cycle, made.slots, 0.25);
    }
}

TEST_CASE("frames of one exposure are a cycle of one, however their scene moves") {
  const std::vector<Exposure> cycle{exposure_of(4)};
  for (const double error : {0.003, 0.03, 0.1}) {
    const StepsByLag steps = steps_by_lag(cycle, std::vector<int>(40, 0), 1, error);
    CAPTURE(error);
    const auto found = estimate_cycle(steps);
    REQUIRE(found.ok());
    CHECK(found.value().size() == 1);
  }
}

TEST_CASE("pictures that repeat over no number of frames much better than over others show no cycle") {
  StepsByLag steps(4);
  const double sizes[] = {0.152, 0.193, 0.142, 0.187};
  for (std::size_t lag = 1; lag <= 4; ++lag)
    for (std::size_t i = 0; i < 24 - lag; ++i)
      steps[lag - 1].push_back({StepKind::Measured, i % 2 == 0 ? sizes[lag - 1] : -sizes[lag - 1], 0});
  const auto refused = estimate_cycle(steps);
  REQUIRE_FALSE(refused.ok());
  CHECK_THAT(refused.error().message, Contains("--shutter"));
}

TEST_CASE("noise is no cycle") {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  StepsByLag steps(4);
  for (auto& of_lag : steps)
    for (int i = 0; i < 40; ++i) of_lag.push_back({StepKind::Measured, 2 * normal(random), 0});
  const auto refused = estimate_cycle(steps);
  REQUIRE_FALSE(refused.ok());
  CHECK_THAT(refused.error().message, Contains("--shutter"));
}
