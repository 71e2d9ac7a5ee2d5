// The emitted picture against the truth: absolute floors, what each part of the method must be worth, and
// whether the claimed uncertainty holds. All numbers are in bounds.h. Clips are filmed and run once a
// process.
#include <cmath>
#include <map>
#include <tuple>

#include "render/scores/ground_truth.h"
#include "tests/contracts/expect.h"
#include "tests/quality/bounds.h"
#include "tests/quality/simulated_clip.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using namespace hdrcam::test;

namespace {

struct Outcome {
  EmittedClip emitted;
  ClipScores scores;
};

const SimulatedClip& clip_of(const FloorClip& wanted) {
  static std::map<std::string, SimulatedClip> clips;
  const std::string key =
      fmt::format("{} {} {} {}", wanted.scene, wanted.shutter, wanted.frames, wanted.format);
  const auto found = clips.find(key);
  if (found != clips.end()) return found->second;
  return clips.emplace(key, film(wanted.scene, wanted.shutter, wanted.frames, wanted.format)).first->second;
}

const Outcome& outcome_of(const FloorClip& wanted, Preset preset, EmitLayer layer, Change change) {
  static std::map<std::tuple<std::string, int, Preset, EmitLayer, Change>, Outcome> outcomes;
  const std::tuple key{std::string(wanted.scene), wanted.frames, preset, layer, change};
  const auto found = outcomes.find(key);
  if (found != outcomes.end()) return found->second;
  const SimulatedClip& clip = clip_of(wanted);
  PipelineOptions options = options_of(preset, layer);
  change(options);
  Outcome outcome{emit(clip, options), {}};
  outcome.scores = scores_of(clip, outcome.emitted);
  return outcomes.emplace(key, std::move(outcome)).first->second;
}

std::string in_words(const ClipScores& scores) {
  return fmt::format("PSNR-mu {:.2f} dB, worst {:.2f} dB, flicker {:.4f} stops, phase {:.4f} stops",
                     scores.mean.psnr_mu_db, scores.worst.picture.psnr_mu_db,
                     scores.flicker_stops.value_or(9), scores.phase_stops);
}

}  // namespace

TEST_CASE("every layer, look-ahead and preset reaches its floor against the truth", "[floor]") {
  for (const PictureFloor& floor : kPictureFloors) {
    const ClipScores& scores = outcome_of(floor.clip, floor.preset, floor.layer, floor.change).scores;
    INFO(floor.name << ": " << in_words(scores));
    CHECK(scores.missing.empty());
    CHECK(scores.mean.psnr_mu_db >= floor.psnr_mu_db);
    CHECK(scores.worst.picture.psnr_mu_db >= floor.worst_db);
    CHECK(scores.flicker_stops.value_or(9) <= floor.flicker_stops);
    CHECK(scores.phase_stops <= floor.phase_stops);
  }
}

TEST_CASE("each part of the method pays", "[floor]") {
  for (const PartWorth& worth : kPartWorths) {
    const ClipScores& with = outcome_of(worth.clip, Preset::Balanced, EmitLayer::State, leave).scores;
    const ClipScores& without =
        outcome_of(worth.clip, Preset::Balanced, EmitLayer::State, worth.without).scores;
    INFO("with " << worth.part << ": " << in_words(with) << "\nwithout: " << in_words(without));
    CHECK(with.mean.psnr_mu_db - without.mean.psnr_mu_db >= worth.psnr_mu_db);
    CHECK(*without.flicker_stops - *with.flicker_stops >= worth.flicker_stops);
  }
}

TEST_CASE("fast, balanced and best rise in work and in quality", "[floor]") {
  const auto merged = [](Preset preset) -> const Outcome& {
    return outcome_of(kShortWalk, preset, EmitLayer::Merged, leave);
  };
  const auto samples = [&](Preset preset) {  // of the fit, counted where they are drawn
    const FitBudget fit = options_of(preset, EmitLayer::Merged).knobs.budget.fit;
    return static_cast<double>(merged(preset).emitted.fit_steps) * fit.rays_per_step * fit.samples_per_ray;
  };
  const Preset presets[] = {Preset::Fast, Preset::Balanced, Preset::Best};
  for (int i = 0; i + 1 < 3; ++i) {
    const Preset lesser = presets[i], greater = presets[i + 1];
    INFO(name(lesser) << ": " << in_words(merged(lesser).scores) << "\n"
                      << name(greater) << ": " << in_words(merged(greater).scores));
    CHECK(samples(greater) > 1.2 * samples(lesser));
    const bool finer_flow = options_of(greater, EmitLayer::Merged).knobs.budget.flow >
                            options_of(lesser, EmitLayer::Merged).knobs.budget.flow;
    CHECK(finer_flow == (lesser == Preset::Fast));
    CHECK(merged(greater).scores.mean.psnr_mu_db - merged(lesser).scores.mean.psnr_mu_db >=
          (finer_flow ? kFinerFlow_db : kNotWorse_db));
  }
}

TEST_CASE("a field that is fitted beside the state leaves its picture as it is", "[floor]") {
  const Outcome& state = outcome_of(kShortWalk, Preset::Fast, EmitLayer::State, leave);
  const Outcome& merged = outcome_of(kShortWalk, Preset::Fast, EmitLayer::Merged, leave);
  CHECK(merged.emitted.fit_steps > 0);
  REQUIRE(merged.emitted.frames.size() == state.emitted.frames.size());
  for (std::size_t i = 0; i < state.emitted.frames.size(); ++i)
    CHECK(std::ranges::equal(merged.emitted.frames[i].radiance.samples(),
                             state.emitted.frames[i].radiance.samples()));
}

TEST_CASE(
    "a field that fills leaves the rest as it is, and its answer where nobody saw the pixel is as near to "
    "the truth",
    "[floor]") {
  const SimulatedClip& clip = clip_of(kShortWalk);
  const Outcome& state = outcome_of(kShortWalk, Preset::Fast, EmitLayer::State, leave);
  const Outcome& merged = outcome_of(kShortWalk, Preset::Fast, EmitLayer::Merged, fill);
  const GroundTruth truth = value_of(GroundTruth::open(posix_storage(), clip.folder));
  int answers = 0, elsewhere = 0, lower = 0;
  double of_bound = 0, of_answer = 0;  // |log2| errors
  for (std::size_t i = 0; i < merged.emitted.frames.size(); ++i) {
    const HdrFrame &before = state.emitted.frames[i], &after = merged.emitted.frames[i];
    const Image<float> expected = value_of(truth.radiance(static_cast<int>(i)));
    for (int c = 0; c < 3; ++c) {
      const auto gain = static_cast<float>(state.scores.shared.gain[static_cast<std::size_t>(c)]);
      for (int y = 0; y < expected.rows(); ++y)
        for (int x = 0; x < expected.cols(); ++x) {
          const float bound = before.radiance.at(c, y, x), answer = after.radiance.at(c, y, x);
          if (answer == bound) continue;
          lower += answer < bound ? 1 : 0;
          if (after.provenance.at(0, y, x) != static_cast<std::uint8_t>(Provenance::Field)) {
            ++elsewhere;
            continue;
          }
          ++answers;
          of_bound += std::abs(std::log2(static_cast<double>(gain * bound / expected.at(c, y, x))));
          of_answer += std::abs(std::log2(static_cast<double>(gain * answer / expected.at(c, y, x))));
        }
    }
  }
  INFO(answers << " answers, mean error " << of_bound / answers << " -> " << of_answer / answers << " stops");
  CHECK(elsewhere == 0);
  CHECK(lower == 0);
  CHECK(answers >= kFieldAnswers);
  CHECK(of_answer <= kFieldErrorShare * of_bound);
}

TEST_CASE("the field alone is a picture of its own", "[floor]") {
  const Outcome& state = outcome_of(kShortWalk, Preset::Fast, EmitLayer::State, leave);
  const Outcome& field = outcome_of(kShortWalk, Preset::Fast, EmitLayer::Field, leave);
  double difference = 0, samples = 0;
  for (std::size_t i = 0; i < field.emitted.frames.size(); ++i) {
    const auto own = field.emitted.frames[i].radiance.samples();
    const auto other = state.emitted.frames[i].radiance.samples();
    for (std::size_t k = 0; k < own.size(); ++k, ++samples)
      difference += std::abs(std::log2(static_cast<double>((own[k] + 1e-3f) / (other[k] + 1e-3f))));
    for (const std::uint8_t from : field.emitted.frames[i].provenance.samples())
      REQUIRE(from == static_cast<std::uint8_t>(Provenance::Field));
  }
  INFO("mean difference " << difference / samples << " stops");
  CHECK(difference / samples >= kFieldFromState_stops);
}

TEST_CASE("the claimed variance holds for own, carried and look-ahead pixels, and bounds are bounds",
          "[floor]") {
  const Outcome& outcome = outcome_of(kWalk, Preset::Balanced, EmitLayer::State, no_shrinkage);
  const Calibration calibration = calibration_of(clip_of(kWalk), outcome.emitted, outcome.scores);
  for (const ClaimedVariance& claim : kClaimedVariances) {
    const auto& ratio = calibration.ratios[static_cast<std::size_t>(claim.provenance)];
    REQUIRE(ratio);
    INFO("provenance " << static_cast<int>(claim.provenance) << ": median " << ratio->median << ", sums "
                       << ratio->of_sums << " over " << ratio->pixels << " pixels");
    CHECK(ratio->median >= claim.least_median);
    CHECK(ratio->median <= claim.most_median);
    CHECK(ratio->of_sums <= claim.most_sum);
  }
  INFO(calibration.bounds_kept << " of the bounds hold");
  CHECK(calibration.bounds_kept >= kBoundsKept);
}
