// Exposures that follow the motion, in closed loop, beside the fixed cycle with which they begin: the same
// scene and seed, scored against the truth of each frame's own instant. The bounds leave room for another
// machine's rounding. `./run test "[closed-loop]"` prints the scores of all scenes at full size, for minutes.
#include "tests/quality/closed_loop.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>

using namespace hdrcam;
using namespace hdrcam::test;

namespace {

struct Comparison {
  LoopOutcome fixed, motion;

  double mean_gain_db() const { return motion.mean_db - fixed.mean_db; }
  double worst_gain_db() const { return motion.worst_db - fixed.worst_db; }
  std::string in_words() const {
    std::string text =
        fmt::format("fixed {:.2f} / {:.2f} dB, motion {:.2f} / {:.2f} dB, {:+.2f} / {:+.2f};", fixed.mean_db,
                    fixed.worst_db, motion.mean_db, motion.worst_db, mean_gain_db(), worst_gain_db());
    for (const Exposure& exposure : motion.last_cycle) text += fmt::format(" {}", describe(exposure));
    return text + fmt::format("; {} wrong labels", fixed.wrong_labels + motion.wrong_labels);
  }
};

Comparison compared(const std::string& scene, int frames) {
  const auto loop = [&](Adapt adapt) {
    LoopRun run{.scene = scene, .frames = frames};
    run.schedule.adapt = adapt;
    return closed_loop(run);
  };
  return {loop(Adapt::Off), loop(Adapt::Motion)};
}

bool says(const RunRecord& record, std::string_view words) {
  for (const std::string& note : record.notes)
    if (note.find(words) != std::string::npos) return true;
  return false;
}

}  // namespace

TEST_CASE("exposures that follow the motion make better pictures of what moves, and no label is wrong",
          "[floor]") {
  const Comparison quick = compared("walk?size=128x96&seed=3&speed=3", 48);
  INFO(quick.in_words());
  CHECK(quick.fixed.changes == 0);
  CHECK(quick.motion.changes >= 1);
  CHECK(quick.mean_gain_db() >= 1.5);
  CHECK(quick.worst_gain_db() >= 3);
  CHECK(quick.fixed.wrong_labels + quick.motion.wrong_labels == 0);
  CHECK(says(quick.motion.record, "the fit asked for other exposures"));
  CHECK_FALSE(says(quick.fixed.record, "the fit asked for"));
}

TEST_CASE("exposures that follow the motion make no picture worse of what rests", "[floor]") {
  const Comparison rest = compared("still?size=128x96", 48);
  INFO(rest.in_words());
  CHECK(rest.mean_gain_db() >= -0.1);
  CHECK(rest.motion.wrong_labels == 0);
}

TEST_CASE("the scores in closed loop, scene by scene", "[.][closed-loop]") {
  constexpr const char* kMoving[] = {"walk", "fast", "lamps", "night", "pan"};
  constexpr int kSeeds[] = {1, 7, 8, 9, 11, 21, 22, 23, 24};  // 1: the scenes as they are without a seed
  double mean = 0, worst = 0;
  for (const int seed : kSeeds) {
    double mean_of_seed = 0, worst_of_seed = 0;
    for (const char* scene : kMoving) {
      const Comparison loop = compared(fmt::format("{}?seed={}", scene, seed), 60);
      WARN(scene << " " << seed << ": " << loop.in_words());
      CHECK(loop.motion.wrong_labels == 0);
      mean_of_seed += loop.mean_gain_db() / std::size(kMoving);
      worst_of_seed += loop.worst_gain_db() / std::size(kMoving);
    }
    WARN(fmt::format("moving, seed {}: {:+.2f} / {:+.2f} dB", seed, mean_of_seed, worst_of_seed));
    mean += mean_of_seed / std::size(kSeeds), worst += worst_of_seed / std::size(kSeeds);
  }
  WARN(fmt::format("moving, mean: {:+.2f} / {:+.2f} dB", mean, worst));
  WARN("still: " << compared("still", 60).in_words());
}
