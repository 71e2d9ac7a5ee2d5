// Pictures and claims by hand. The scene stands still, so that the ratio of two pictures is that of their
// exposures, to within a tenth of its logarithm to each side.
#include "capture/exposure_proof.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

using namespace std::chrono_literals;

constexpr Exposure k1{1ms, 1}, k4{4ms, 1}, k16{16ms, 1};
constexpr Exposure kThree[] = {k1, k4, k16};

ExposureClaim predicted(const Exposure& exposure) { return {exposure, 1, ExposureSource::Predicted}; }
ExposureClaim reported(const Exposure& exposure) { return {exposure, 1, ExposureSource::Reported}; }

FrameEvidence claims(std::initializer_list<ExposureClaim> list) {
  FrameEvidence evidence;
  evidence.claims = list;
  return evidence;
}

// The scene as the exposure shows it; of several stops of contrast, none clipped.
PhotometricSignature picture_of(double log_exposure) {
  PhotometricSignature picture;
  picture.rows = PhotometricSignature::kSiteRows, picture.cols = PhotometricSignature::kSiteCols;
  picture.sites = PhotometricSignature::kSites;
  for (std::size_t i = 0; i < picture.at_site.size(); ++i)
    picture.at_site[i] = static_cast<float>(log_exposure + std::sin(static_cast<double>(i * i % 1009)));
  picture.by_rank = picture.at_site;
  std::sort(picture.by_rank.begin(), picture.by_rank.end());
  return picture;
}

// Nothing can be compared with it.
PhotometricSignature dark() {
  PhotometricSignature picture = picture_of(0);
  picture.at_site.fill(-std::numeric_limits<float>::infinity());
  picture.by_rank = picture.at_site;
  return picture;
}

class Bench {
 public:
  explicit Bench(std::span<const Exposure> cycle) { proof_->set_cycle(cycle); }
  ExposureProof& proof() { return *proof_; }
  Judgement judge(const FrameEvidence& evidence, const PhotometricSignature& picture) {
    return proof_->judge(evidence, picture, photometer_);
  }
  // The sensor does this exposure.
  Judgement judge(const Exposure& truth, const FrameEvidence& evidence) {
    return judge(evidence, picture_of(log_product(truth)));
  }
  // Whole cycles with right predictions.
  void prove(std::span<const Exposure> cycle, int rounds = 5) {
    for (int i = 0; i < rounds; ++i)
      for (const Exposure& exposure : cycle) last_ = judge(exposure, claims({predicted(exposure)}));
    REQUIRE(last_.verdict == Verdict::Proved);
  }

 private:
  Photometer photometer_{PhotometricResponse::linear(BlackLevel())};
  std::unique_ptr<ExposureProof> proof_ = std::make_unique<ExposureProof>();
  Judgement last_;
};

TEST_CASE("one ratio of 4 fits two places of a cycle 1:4:16, and the ratios after it settle it",
          "[capture]") {
  // From which frame on the pictures are unanimous: no other exposure leaves out fewer than two frames.
  struct Row {
    std::vector<Exposure> shown;
    int unique_from;
  };
  const Row rows[] = {
      {{k1, k4, k16, k1, k4, k16, k1}, 5},
      {{k4, k16, k1, k4, k16, k1, k4}, 5},
      {{k16, k1, k4, k16, k1, k4, k16}, 4},
      {{k1, k4, k1, k4, k1, k4, k1, k4}, 99},  // as well 4 and 16
      {{k1, k16, k1, k16}, 3},
  };
  for (const Row& row : rows) {
    Bench bench(kThree);
    for (std::size_t i = 0; i < row.shown.size(); ++i) {
      CAPTURE(&row - rows, i);
      const Judgement judgement = bench.judge(row.shown[i], {});
      const bool unique = static_cast<int>(i) >= row.unique_from;
      CHECK(judgement.unique.has_value() == unique);
      CHECK(judgement.verdict == (unique ? Verdict::Plausible : Verdict::Unknown));
      if (!unique) continue;
      CHECK(judgement.label.exposure == row.shown[i]);
      CHECK(judgement.label.source == ExposureSource::Photometric);
      CHECK_FALSE(judgement.relabelled);
    }
  }
}

TEST_CASE("a claim is proved once the pictures are unanimous, and wrong claims are relabelled", "[capture]") {
  Bench right(kThree), late(kThree);
  for (int i = 0; i < 12; ++i) {
    CAPTURE(i);
    const Exposure& truth = kThree[i % 3];
    const Judgement proved = right.judge(truth, claims({predicted(truth)}));
    CHECK(proved.verdict == (i >= 5 ? Verdict::Proved : Verdict::Plausible));
    CHECK(proved.label.source == ExposureSource::Predicted);
    // The logarithm of a ratio of 4 is known to a tenth, and to 3 %, the stretch of a linear response. That
    // a frame of the same exposure is nearer does not help: its own exposure is not known better.
    const double open = (std::log(4) + 0.1) * 1.03 - std::log(4);
    if (i >= 7) CHECK(proved.within_ev == Approx(open / std::log(2)).epsilon(0.02));
    const Judgement wrong = late.judge(truth, claims({predicted(kThree[(i + 2) % 3])}));
    CHECK(wrong.verdict != Verdict::Proved);
    if (i < 5) continue;
    CHECK(wrong.verdict == Verdict::Plausible);
    CHECK(wrong.relabelled);
    CHECK(wrong.label.exposure == truth);
    CHECK(wrong.label.source == ExposureSource::Photometric);
  }
}

TEST_CASE("what pictures leave open the best claim does not prove, not even the sensor's own", "[capture]") {
  Bench bench(kThree);
  for (std::size_t i = 0; i < 5; ++i) {
    const Judgement judgement =
        bench.judge(kThree[i % 3], claims({{kThree[i % 3], 1, ExposureSource::Embedded}}));
    CHECK(judgement.verdict == Verdict::Plausible);
  }
}

TEST_CASE("frames of which nobody knows the exposure prove no other, though all are unanimous", "[capture]") {
  Bench bench(kThree);
  for (std::size_t i = 0; i < 5; ++i) CHECK_FALSE(bench.judge(kThree[i % 3], {}).trusted());
  const Judgement first = bench.judge(k16, claims({predicted(k16)}));
  CHECK(first.unique);
  CHECK(first.verdict == Verdict::Plausible);
  CHECK(bench.judge(k1, claims({predicted(k1)})).verdict == Verdict::Proved);
}

TEST_CASE("two outliers among the last eight frames leave a proof, three do not", "[capture]") {
  for (const int flashes : {2, 3}) {
    Bench bench(kThree);
    bench.prove(kThree);
    for (int i = 0; i < flashes; ++i)
      bench.judge(claims({predicted(k1)}), picture_of(log_product(k1) + 0.7 + 0.25 * i));
    const Judgement after = bench.judge(k4, claims({predicted(k4)}));
    CHECK(after.verdict == (flashes == 2 ? Verdict::Proved : Verdict::Plausible));
  }
}

TEST_CASE("an exposure outside the cycle is proved where the best claim states it and pictures show it",
          "[capture]") {
  constexpr Exposure k9{9ms, 1}, kNear{17ms, 1};
  Bench bench(kThree);
  bench.prove(kThree);
  const Judgement cut_off = bench.judge(k9, claims({reported(k9), predicted(k16)}));
  CHECK(cut_off.verdict == Verdict::Proved);
  CHECK(cut_off.label.exposure == k9);

  // Stated, and not what the pictures show: they know the exposures of the cycle.
  const Judgement as_asked = bench.judge(k16, claims({reported(k9), predicted(k16)}));
  CHECK(as_asked.verdict == Verdict::Plausible);
  CHECK(as_asked.label.exposure == k16);
  CHECK(as_asked.label.source == ExposureSource::Predicted);
  CHECK_FALSE(as_asked.relabelled);

  // Shown, and stated by nobody.
  const Judgement nobody = bench.judge(k9, claims({predicted(k16)}));
  CHECK(nobody.verdict == Verdict::Contradicted);

  // So near to 16 ms that no picture tells the two apart: the claim stands for both.
  const Judgement near = bench.judge(kNear, claims({reported(kNear)}));
  CHECK(near.verdict == Verdict::Proved);
  CHECK(near.label.exposure == kNear);
  const Judgement near_claimed = bench.judge(k16, claims({reported(kNear)}));
  CHECK(near_claimed.verdict == Verdict::Proved);
}

TEST_CASE("where claims disagree the pictures choose, and where they cannot nobody does", "[capture]") {
  Bench bench(kThree);
  bench.prove(kThree);
  const Judgement second = bench.judge(k4, claims({reported(k16), predicted(k4)}));
  CHECK(second.verdict == Verdict::Plausible);
  CHECK(second.label.exposure == k4);
  CHECK(second.label.source == ExposureSource::Predicted);
  CHECK_FALSE(second.relabelled);
  CHECK(bench.judge(k4, claims({reported(k4), predicted(k16)})).verdict == Verdict::Proved);
  const Judgement third = bench.judge(k4, claims({reported(k16), predicted(k1)}));
  CHECK(third.verdict == Verdict::Plausible);
  CHECK(third.relabelled);

  CHECK(bench.judge(claims({reported(k4), predicted(k16)}), dark()).verdict == Verdict::Unknown);
  CHECK(bench.judge(claims({reported(k4), predicted(k4)}), dark()).verdict == Verdict::Plausible);
  CHECK(bench.judge(claims({predicted(k4)}), dark()).verdict == Verdict::Plausible);
  CHECK(bench.judge({}, dark()).verdict == Verdict::Unknown);
}

TEST_CASE("a doubtful prediction counts where the pictures confirm it, and not where they are blind",
          "[capture]") {
  Bench bench(kThree);
  bench.prove(kThree);
  FrameEvidence evidence = claims({predicted(k1)});
  evidence.prediction_doubtful = true;
  CHECK(bench.judge(k1, evidence).verdict == Verdict::Proved);
  CHECK(bench.judge(evidence, dark()).verdict == Verdict::Unknown);
  evidence = claims({reported(k4), predicted(k4)});
  evidence.prediction_doubtful = true;  // the report does not depend on when controls were written
  CHECK(bench.judge(evidence, dark()).verdict == Verdict::Plausible);
}

TEST_CASE("a frame that fits nothing is contradicted, and the frames after it are not", "[capture]") {
  for (const double light : {0.7, -0.7, 3.5}) {
    Bench bench(kThree);
    bench.prove(kThree);
    const Judgement flash = bench.judge(claims({predicted(k1)}), picture_of(log_product(k1) + light));
    CAPTURE(light);
    CHECK(flash.verdict == Verdict::Contradicted);
    CHECK_FALSE(flash.unique);
    CHECK_FALSE(flash.trusted());
    for (int i = 1; i < 12; ++i) {
      const Judgement after = bench.judge(kThree[i % 3], claims({predicted(kThree[i % 3])}));
      CHECK(after.verdict == Verdict::Proved);
      CHECK(after.label.exposure == kThree[i % 3]);
    }
  }
}

TEST_CASE("two quick changes of the cycle: frames of all three are proved, none by another's exposures",
          "[capture]") {
  constexpr Exposure kBrighter[] = {{2ms, 1}, {8ms, 1}, {30ms, 1}};
  constexpr Exposure kDarker[] = {{500us, 1}, {3ms, 1}, {12ms, 1}};
  Bench bench(kThree);
  bench.prove(kThree);
  bench.proof().set_cycle(kBrighter);
  bench.proof().set_cycle(kDarker);
  // Requests of the first cycle and of the second are still queued.
  std::vector<Exposure> queued;
  for (int i = 0; i < 8; ++i) queued.push_back(kThree[i % 3]);
  for (int i = 0; i < 2; ++i) queued.push_back(kBrighter[i % 3]);
  for (int i = 0; i < 30; ++i) queued.push_back(kDarker[i % 3]);
  for (std::size_t i = 0; i < queued.size(); ++i) {
    CAPTURE(i);
    const Judgement judgement = bench.judge(queued[i], claims({predicted(queued[i])}));
    CHECK(judgement.verdict == Verdict::Proved);
    CHECK(judgement.label.exposure == queued[i]);
  }
  // After so many proved frames of the last cycle the one before it is no candidate any more.
  const Judgement retired = bench.judge(kBrighter[1], claims({predicted(kDarker[1])}));
  CHECK(retired.verdict == Verdict::Contradicted);
}

TEST_CASE("after a change of the cycle a wrong claim is corrected to an exposure of either", "[capture]") {
  constexpr Exposure kBrighter[] = {{2ms, 1}, {8ms, 1}, {30ms, 1}};
  Bench bench(kThree);
  bench.prove(kThree);
  bench.proof().set_cycle(kBrighter);
  const Judgement before = bench.judge(k4, claims({predicted(kBrighter[0])}));
  CHECK(before.label.exposure == k4);
  CHECK(before.relabelled);
  const Judgement after = bench.judge(kBrighter[1], claims({predicted(k16)}));
  CHECK(after.label.exposure == kBrighter[1]);
  CHECK(after.relabelled);
}

TEST_CASE(
    "a cycle that became brighter as a whole is told from the one before it once no request carries that",
    "[capture]") {
  constexpr Exposure kTwice[] = {{2ms, 1}, {8ms, 1}, {32ms, 1}};  // the same ratios
  for (const bool claimed : {false, true}) {
    // Without claims, or with those of the next slot, no frame is ever proved.
    const auto evidence = [&](std::span<const Exposure> cycle, std::size_t i) {
      return claimed ? claims({predicted(cycle[(i + 1) % 3])}) : FrameEvidence{};
    };
    Bench bench(kThree);
    for (std::size_t i = 0; i < 20; ++i) bench.judge(kThree[i % 3], evidence(kThree, i));
    bench.proof().set_cycle(kTwice);
    for (std::size_t i = 0; i < 100; ++i) {
      const Judgement judgement = bench.judge(kTwice[i % 3], evidence(kTwice, i));
      CAPTURE(claimed, i);
      if (judgement.trusted()) CHECK(judgement.label.exposure == kTwice[i % 3]);
      if (i >= 64) CHECK(judgement.verdict == Verdict::Plausible);
    }
  }
}

TEST_CASE("right claims are proved again after a change by one factor that no picture tells", "[capture]") {
  struct Row {
    std::vector<Exposure> cycle;  // the same ratios
    bool forgets;                 // frames before the change
  };
  const Row rows[] = {{{{1060us, 1}, {4240us, 1}, {16960us, 1}}, false},  // as near as pictures can tell
                      {{{2ms, 1}, {8ms, 1}, {32ms, 1}}, true}};
  for (const Row& row : rows) {
    Bench bench(kThree);
    bench.prove(kThree);
    bench.proof().set_cycle(row.cycle);
    if (row.forgets) bench.proof().forget();
    for (std::size_t i = 0; i < 100; ++i) {
      const Judgement judgement = bench.judge(row.cycle[i % 3], claims({predicted(row.cycle[i % 3])}));
      CAPTURE(row.forgets, i);
      CHECK(judgement.label.exposure == row.cycle[i % 3]);
      CHECK(judgement.verdict == (i < 48 ? Verdict::Plausible : Verdict::Proved));
    }
  }
}

TEST_CASE("two quick changes by one factor: no frame gets a wrong label", "[capture]") {
  constexpr Exposure kTwice[] = {{2ms, 1}, {8ms, 1}, {32ms, 1}},
                     kThrice[] = {{3ms, 1}, {12ms, 1}, {48ms, 1}};  // the same ratios
  for (const bool claimed : {false, true})
    for (const std::size_t between : {2, 5, 9, 13}) {
      // Without claims, or with those of the next slot.
      const auto evidence = [&](std::span<const Exposure> cycle, std::size_t i) {
        return claimed ? claims({predicted(cycle[(i + 1) % 3])}) : FrameEvidence{};
      };
      Bench bench(kThree);
      const auto expect_right = [&](std::span<const Exposure> shown, std::span<const Exposure> asked,
                                    std::size_t frames) {
        for (std::size_t i = 0; i < frames; ++i) {
          const Judgement judgement = bench.judge(shown[i % 3], evidence(asked, i));
          CAPTURE(claimed, between, i, judgement.relabelled);
          if (judgement.trusted())
            CHECK(to_seconds(judgement.label.exposure.time) == to_seconds(shown[i % 3].time));
        }
      };
      for (std::size_t i = 0; i < 20; ++i) bench.judge(kThree[i % 3], evidence(kThree, i));
      // Requests of the cycle before are still queued when the next one is set.
      bench.proof().set_cycle(kTwice);
      expect_right(kThree, kThree, between);
      bench.proof().set_cycle(kThrice);
      expect_right(kThree, kThree, 2);
      expect_right(kTwice, kTwice, between);
      expect_right(kThrice, kThrice, 100);
    }
}

TEST_CASE("a change of the cycle that the camera ignores is never proved", "[capture]") {
  constexpr Exposure kOther[] = {{2ms, 1}, {5ms, 1}, {20ms, 1}}, kTwice[] = {{2ms, 1}, {8ms, 1}, {32ms, 1}};
  for (const std::span<const Exposure> cycle : {std::span<const Exposure>(kOther), {kTwice}}) {
    Bench bench(kThree);
    bench.prove(kThree);
    bench.proof().set_cycle(cycle);
    for (std::size_t i = 0; i < 100; ++i) {
      const Judgement judgement = bench.judge(kThree[i % 3], claims({predicted(cycle[i % 3])}));
      CAPTURE(to_seconds(cycle[2].time), i);
      CHECK(judgement.verdict != Verdict::Proved);
      // Where its ratios are others, pictures tell it for as long as it lasts.
      if (cycle.data() == kOther) CHECK((judgement.relabelled && judgement.label.exposure == kThree[i % 3]));
    }
  }
}

TEST_CASE("pictures of one exposure prove nothing, the sensor's embedded data does", "[capture]") {
  constexpr Exposure kOne[] = {k4};
  for (const ExposureSource source :
       {ExposureSource::Predicted, ExposureSource::Reported, ExposureSource::Embedded}) {
    Bench bench(kOne);
    Judgement last;
    for (int i = 0; i < 8; ++i) last = bench.judge(k4, claims({{k4, 1, source}}));
    CAPTURE(static_cast<int>(source));
    CHECK(last.verdict == (source == ExposureSource::Embedded ? Verdict::Proved : Verdict::Plausible));
  }
}

TEST_CASE("the sensor's own word on its one exposure needs two pictures that agree with this one",
          "[capture]") {
  constexpr Exposure kOne[] = {k4};
  const FrameEvidence evidence = claims({{k4, 1, ExposureSource::Embedded}});
  Bench seen(kOne), blind(kOne), mixed(kOne);
  for (int i = 0; i < 6; ++i) {
    CAPTURE(i);
    CHECK(seen.judge(k4, evidence).verdict == (i < 2 ? Verdict::Plausible : Verdict::Proved));
    CHECK(blind.judge(evidence, dark()).verdict == Verdict::Plausible);
    // where every second frame is dark the others have two to agree with from the third of them on
    const Judgement judgement = i % 2 == 0 ? mixed.judge(k4, evidence) : mixed.judge(evidence, dark());
    CHECK(judgement.verdict == (i == 4 ? Verdict::Proved : Verdict::Plausible));
  }
}

TEST_CASE("where exposures differ and no cycle is known, the sensor's embedded data proves nothing",
          "[capture]") {
  constexpr Exposure kFive[] = {k1, {2ms, 1}, k4, {8ms, 1}, k16};
  Bench bench(std::span<const Exposure>{});
  for (std::size_t i = 0; i < 15; ++i) {
    CAPTURE(i);
    const Exposure& truth = kFive[i % 5];
    const Judgement judgement = bench.judge(truth, claims({{truth, 1, ExposureSource::Embedded}}));
    CHECK(judgement.verdict == Verdict::Plausible);
    CHECK(judgement.label.exposure == truth);
  }
}

TEST_CASE("a strobe pulse decides alone what pictures leave open", "[capture]") {
  Bench bench(kThree);
  FrameEvidence evidence = claims({predicted(k4)});
  evidence.strobe_width = 4ms + 15us;
  const Judgement right = bench.judge(evidence, dark());
  CHECK(right.verdict == Verdict::Proved);
  CHECK(right.within_ev == Approx(std::log2(1 + 0.31 / 4)));  // the latency of interrupts, and a 16th
  evidence.strobe_width = 16ms;
  const Judgement other = bench.judge(evidence, dark());
  CHECK(other.verdict == Verdict::Plausible);
  CHECK(other.label.exposure == k16);
  CHECK(other.relabelled);
  evidence.strobe_width = 9ms;  // of no exposure of the cycle
  CHECK(bench.judge(evidence, dark()).verdict == Verdict::Contradicted);

  // Two witnesses against each other: the pulse says 4 ms, the pictures that it was twice the light.
  evidence.strobe_width = 4ms;
  bench.proof().forget();
  CHECK(bench.judge(evidence, picture_of(log_product(k4))).verdict == Verdict::Proved);
  CHECK(bench.judge(evidence, picture_of(log_product(k4) + 0.7)).verdict == Verdict::Contradicted);
}

TEST_CASE("a strobe pulse of another length does not outweigh what the sensor embeds in the frame",
          "[capture]") {
  FrameEvidence evidence = claims({{k4, 1, ExposureSource::Embedded}});
  evidence.strobe_width = 16ms;
  Bench three(kThree);
  const Judgement in_the_dark = three.judge(evidence, dark());
  CHECK(in_the_dark.verdict == Verdict::Plausible);
  CHECK(in_the_dark.label.exposure == k4);
  CHECK(in_the_dark.strobe_refuses);
  three.prove(kThree);
  const Judgement seen = three.judge(k4, evidence);
  CHECK(seen.verdict == Verdict::Proved);
  CHECK(seen.label.exposure == k4);
  CHECK(seen.strobe_refuses);
  // the pulse is right where the pictures say so
  const Judgement as_pulse = three.judge(k16, evidence);
  CHECK(as_pulse.verdict == Verdict::Plausible);
  CHECK(as_pulse.label.exposure == k16);

  constexpr Exposure kOne[] = {k4};
  Bench one(kOne);
  for (int i = 0; i < 8; ++i) CHECK(one.judge(k4, evidence).verdict == Verdict::Plausible);
}

// A control delay that is wrong for the time alone, and corrected by the strobe: the gain is another slot's.
TEST_CASE("a strobe pulse shows no gain, so that a time with the gain of another slot is never proved",
          "[capture]") {
  constexpr Exposure kAmplified[] = {{250us, 1}, {1ms, 1}, {4ms, 2}};
  for (const bool longest_seen : {false, true}) {
    Bench bench(kAmplified);
    for (std::size_t i = 0; i < 30; ++i) {
      const Exposure &claimed = kAmplified[i % 3], shown{claimed.time, kAmplified[(i + 2) % 3].gain};
      FrameEvidence evidence = claims({predicted(claimed)});
      evidence.strobe_width = claimed.time + 15us;
      const Judgement judgement =
          claimed.time == 4ms && !longest_seen ? bench.judge(evidence, dark()) : bench.judge(shown, evidence);
      CAPTURE(longest_seen, i);
      const bool wrongly_proved =
          judgement.verdict == Verdict::Proved && !(judgement.label.exposure == shown);
      CHECK_FALSE(wrongly_proved);
    }
  }
}

TEST_CASE("with a strobe frames of different gains are proved as soon as pictures tell the gain",
          "[capture]") {
  constexpr Exposure kAmplified[] = {{250us, 1}, {1ms, 1}, {4ms, 2}};
  Bench bench(kAmplified);
  for (std::size_t i = 0; i < 30; ++i) {
    const Exposure& exposure = kAmplified[i % 3];
    FrameEvidence evidence = claims({predicted(exposure)});
    evidence.strobe_width = exposure.time + 15us;
    const bool seen = i != 20;
    const bool told = seen && i >= 2;  // by two pictures of other slots
    const Judgement judgement = seen ? bench.judge(exposure, evidence) : bench.judge(evidence, dark());
    CAPTURE(i);
    CHECK(judgement.verdict == (told ? Verdict::Proved : Verdict::Plausible));
    CHECK(judgement.label.exposure == exposure);
  }
}

TEST_CASE("evidence that is forgotten decides nothing any more", "[capture]") {
  Bench bench(kThree);
  bench.prove(kThree);
  bench.proof().forget();
  const Judgement judgement = bench.judge(k4, claims({predicted(k1)}));
  CHECK(judgement.verdict == Verdict::Plausible);
  CHECK(judgement.label.exposure == k1);
}

}  // namespace
}  // namespace hdrcam
