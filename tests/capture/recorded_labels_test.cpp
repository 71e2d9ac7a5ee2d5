// The exposures that a recording states, against its pictures: right ones stay, wrong ones are found.
#include "capture/recording_stage.h"

#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "tests/contracts/expect.h"
#include "tests/support/moving_scene.h"

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

test::MovingScene scene_of(std::vector<double> exposures_s) {
  test::MovingScene scene;
  scene.rows = 120, scene.cols = 160;
  scene.exposures_s = std::move(exposures_s);
  return scene;
}

std::vector<RawFrame> filmed(const test::MovingScene& scene, int count) {
  std::vector<RawFrame> frames;
  for (int i = 0; i < count; ++i) {
    frames.push_back(scene.frame(i));
    frames.back().facts.slot = i % static_cast<int>(scene.exposures_s.size());
  }
  return frames;
}

// A recording in memory.
class Reel : public RecordingReader {
 public:
  Reel(CameraFacts camera, std::vector<RawFrame> frames)
      : camera_(std::move(camera)), frames_(std::move(frames)) {}
  const CameraFacts& camera() const override { return camera_; }
  std::optional<int> frame_count() const override { return static_cast<int>(frames_.size()); }
  Result<std::optional<RawFrame>> next(RawFrame /*room*/) override {
    if (at_ == frames_.size()) return std::optional<RawFrame>();
    return std::optional<RawFrame>(std::move(frames_[at_++]));
  }

 private:
  CameraFacts camera_;
  std::vector<RawFrame> frames_;
  std::size_t at_ = 0;
};

// Each frame in a file of its own.
class ReelOfStills : public Reel {
 public:
  using Reel::Reel;
  std::string file_of(std::uint64_t sequence) const override { return fmt::format("IMG_{}.JPG", sequence); }
};

struct Judged {
  std::vector<FrameFacts> facts;
  CaptureCounters counters;
  std::vector<std::string> warnings;
  std::optional<Error> error;
};

Judged judged(const CameraFacts& camera, std::vector<RawFrame> frames,
              Contradiction contradiction = Contradiction::Warns) {
  RecordingStage stage(std::make_unique<Reel>(camera, std::move(frames)), contradiction);
  Judged result;
  for (CapturedFrame frame;;) {
    const auto more = stage.next(frame);
    if (!more) result.error = more.error();
    if (!more || !more.value()) break;
    result.facts.push_back(frame.raw.facts);
  }
  result.counters = stage.counters();
  result.warnings = stage.warnings();
  return result;
}

Judged judged(const test::MovingScene& scene, std::vector<RawFrame> frames,
              Contradiction contradiction = Contradiction::Warns) {
  return judged(scene.camera(), std::move(frames), contradiction);
}

// The frame that gets the label of frame `index`.
using Relabelling = std::function<int(int index, int count)>;

std::vector<RawFrame> with_labels(const test::MovingScene& scene, int count, const Relabelling& label_of) {
  std::vector<RawFrame> frames = filmed(scene, count);
  const std::vector<RawFrame> truth = filmed(scene, count);
  for (int i = 0; i < count; ++i)
    frames[static_cast<std::size_t>(i)].facts.exposure_s =
        truth[static_cast<std::size_t>(label_of(i, count))].facts.exposure_s;
  return frames;
}

double true_exposure_s(const test::MovingScene& scene, const FrameFacts& facts) {
  return scene.exposures_s[facts.sequence % scene.exposures_s.size()];
}

const std::vector<std::vector<double>> kCycles = {
    {0.001, 0.004, 0.016}, {0.016, 0.004, 0.001}, {0.002, 0.016}, {0.001, 0.002, 0.004, 0.008}};

TEST_CASE("right exposures of a recording stay as they are, and pictures prove them", "[capture]") {
  for (const auto& exposures_s : kCycles) {
    const auto scene = scene_of(exposures_s);
    const Judged result = judged(scene, filmed(scene, 24));
    CAPTURE(exposures_s, result.counters.proved, result.counters.plausible);
    REQUIRE(result.facts.size() == 24);
    CHECK(result.warnings.empty());
    CHECK(result.counters.proved >= 20);
    for (const FrameFacts& facts : result.facts) {
      CHECK(facts.exposure_s == true_exposure_s(scene, facts));
      CHECK(facts.exposure_source == ExposureSource::Declared);
      CHECK((facts.verdict == Verdict::Proved || facts.verdict == Verdict::Plausible));
      CHECK(facts.flags == 0);
    }
  }
}

TEST_CASE("of more than four exposures the pictures prove none, whoever states them", "[capture]") {
  const auto scene = scene_of({0.001, 0.002, 0.004, 0.008, 0.016});
  for (const ExposureSource source : {ExposureSource::Declared, ExposureSource::Embedded}) {
    CAPTURE(static_cast<int>(source));
    std::vector<RawFrame> frames = filmed(scene, 20);
    for (RawFrame& frame : frames) frame.facts.exposure_source = source;
    const Judged result = judged(scene, std::move(frames));
    CHECK(result.counters.proved == 0);
    CHECK(result.counters.plausible == 20);
  }
}

TEST_CASE("where a camera clips below the largest code, exposures are judged by what does not clip",
          "[capture]") {
  auto scene = scene_of({0.001, 0.004, 0.016});
  scene.sensitivity = 1500;
  std::vector<RawFrame> frames = filmed(scene, 24);
  for (RawFrame& frame : frames)
    for (std::uint16_t& code : frame.codes.samples()) code = static_cast<std::uint16_t>(code * 4 / 5);
  const Judged result = judged(scene, std::move(frames));
  CHECK(result.warnings.empty());
  CHECK(result.counters.proved >= 12);
  CHECK(result.counters.contradicted == 0);
}

TEST_CASE(
    "exposures that were estimated from the pictures are estimated, never proved, and right among each other",
    "[capture]") {
  const auto scene = scene_of({0.001, 0.004, 0.016});
  std::vector<RawFrame> frames = with_labels(scene, 24, [](int i, int) { return i == 7 ? 8 : i; });
  for (RawFrame& frame : frames) {
    frame.facts.exposure_source = ExposureSource::Estimated;
    frame.facts.exposure_s *= 100;  // relative: longer than the frames, which nothing says against
  }
  const Judged result = judged(scene, std::move(frames));
  CHECK(result.counters.estimated == 24);
  CHECK(result.counters.relabelled == 1);
  CHECK(proof_of(result.counters) ==
        "exposures: 0 proved, 0 plausible, 24 estimated, 0 contradicted, 0 unknown");
  for (const FrameFacts& facts : result.facts) {
    CHECK(facts.verdict == Verdict::Estimated);
    CHECK(facts.exposure_source == ExposureSource::Estimated);
    CHECK(facts.exposure_s == Approx(100 * true_exposure_s(scene, facts)));
    CHECK(facts.flags == 0);
  }
  REQUIRE(result.warnings.size() == 1);  // of frame 7, and not of times that are none
  CHECK(result.warnings.front().find("frame 7") != std::string::npos);
}

TEST_CASE("exposures shifted by a frame, or told in reverse, are found from the first frame on",
          "[capture]") {
  const std::pair<const char*, Relabelling> errors[] = {
      {"shifted by one", [](int i, int count) { return i + 1 < count ? i + 1 : i - 2; }},
      {"reversed", [](int i, int) { return 2 - i % 3 + i / 3 * 3; }}};
  const auto scene = scene_of({0.001, 0.004, 0.016});
  for (const auto& [what, label_of] : errors) {
    const Judged result = judged(scene, with_labels(scene, 24, label_of));
    CAPTURE(what, result.counters.proved, result.counters.relabelled, result.counters.contradicted);
    for (const FrameFacts& facts : result.facts)
      if ((facts.flags & kFrameExposureUnproved) == 0)
        CHECK(facts.exposure_s == true_exposure_s(scene, facts));
    CHECK(result.counters.relabelled + result.counters.proved >= 23);
    REQUIRE_FALSE(result.warnings.empty());
    CHECK(result.warnings.front().find("relabelled from the pictures; frame ") != std::string::npos);
  }
}

TEST_CASE(
    "exposures in a wrong order are said where neighbours have nothing in common that could be measured",
    "[capture]") {
  auto scene = scene_of({0.000002, 0.0003, 0.03});
  const auto swapped = [&] {
    return with_labels(scene, 24, [](int i, int) { return i % 3 == 2 ? i : i / 3 * 3 + 1 - i % 3; });
  };
  const Judged wrong = judged(scene, swapped());
  CAPTURE(wrong.counters.proved, wrong.counters.plausible, wrong.counters.relabelled);
  REQUIRE(wrong.warnings.size() == 1);
  CHECK(wrong.warnings.front().find("are darker than their neighbours where") != std::string::npos);
  CHECK(judged(scene, swapped(), Contradiction::Fails).error);
  const Judged right = judged(scene, filmed(scene, 24), Contradiction::Fails);
  CHECK_FALSE(right.error);
  CHECK(right.warnings.empty());
}

TEST_CASE("raw frames are judged by the black level that each of them states", "[capture]") {
  auto scene = scene_of({0.001, 0.004, 0.016});
  scene.gamma = 1, scene.full_well = 0;
  CameraFacts camera = scene.camera();
  camera.linear = true;
  std::vector<RawFrame> frames;
  for (int i = 0; i < 24; ++i) {
    scene.black_level = i % 3 == 0 ? 80 : 8;
    scene.sensitivity = 250. * 255 / (255 - scene.black_level);  // a code above black is the same light
    frames.push_back(scene.frame(i));
    frames.back().facts.black_level = BlackLevel(static_cast<float>(scene.black_level));
  }
  const Judged result = judged(camera, std::move(frames));
  CHECK(result.facts.size() == 24);
  CHECK(result.counters.contradicted == 0);
  CHECK(result.warnings.empty());
}

TEST_CASE("raw frames are judged by the black level that the user states instead of theirs", "[capture]") {
  auto scene = scene_of({0.001, 0.004, 0.016});
  scene.gamma = 1, scene.full_well = 0, scene.black_level = 40;
  CameraFacts camera = scene.camera();
  camera.linear = true;
  for (const bool by_user : {false, true}) {
    std::vector<RawFrame> frames = filmed(scene, 24);
    for (RawFrame& frame : frames) frame.facts.black_level = BlackLevel();  // which is wrong
    const std::optional<BlackLevel> stated = by_user ? std::optional(BlackLevel(40)) : std::nullopt;
    RecordingStage stage(std::make_unique<Reel>(camera, std::move(frames)), Contradiction::Warns, stated);
    for (CapturedFrame frame; value_of(stage.next(frame));)
      CHECK(frame.raw.facts.black_level == stated.value_or(BlackLevel()));
    INFO(proof_of(stage.counters()));
    CHECK((stage.counters().contradicted == 0) == by_user);
  }
}

TEST_CASE("raw frames that state no black level are judged by the first one that is stated", "[capture]") {
  auto scene = scene_of({0.001, 0.004, 0.016});
  scene.gamma = 1, scene.full_well = 0, scene.black_level = 80;
  CameraFacts camera = scene.camera();
  camera.linear = true;
  std::vector<RawFrame> frames = filmed(scene, 24);
  for (std::size_t i = 6; i < frames.size(); ++i) frames[i].facts.black_level = BlackLevel(80);
  const Judged result = judged(camera, std::move(frames));
  CHECK(result.counters.contradicted == 0);
  CHECK(result.warnings.empty());
}

TEST_CASE("single frames that are black are no objection to the others", "[capture]") {
  const auto scene = scene_of({0.001, 0.004, 0.016});
  auto frames = filmed(scene, 48);
  for (const std::size_t black : {11u, 20u, 38u}) frames[black].codes.fill(0);
  const Judged result = judged(scene, std::move(frames), Contradiction::Fails);
  CHECK_FALSE(result.error);
  CHECK(result.warnings.empty());
  CHECK(result.facts.size() == 48);
}

TEST_CASE("a recording that states one exposure for all its different frames is told so", "[capture]") {
  const auto scene = scene_of({0.001, 0.004, 0.016});
  const Judged result = judged(scene, with_labels(scene, 24, [](int, int) { return 1; }));
  CHECK(result.counters.relabelled == 0);
  CHECK(result.counters.proved == 0);
  CHECK(result.counters.contradicted >= 8);
  REQUIRE(result.warnings.size() == 1);
  CHECK(result.warnings.front().find("their pictures contradict their exposures") != std::string::npos);
}

TEST_CASE("a recording whose frames all have one exposure is said to give no HDR", "[capture]") {
  const auto scene = scene_of({0.004});
  const Judged result = judged(scene, filmed(scene, 12));
  REQUIRE(result.warnings.size() == 1);
  CHECK(result.warnings.front() ==
        "all 12 frames have the same exposure, 4 ms, and give no HDR; record a cycle such as --shutter "
        "1ms,4ms,16ms");
  CHECK(judged(scene, filmed(scene, 4)).warnings.empty());  // perhaps a part of a cycle

  auto estimated = filmed(scene, 12);  // no times
  for (RawFrame& frame : estimated) frame.facts.exposure_source = ExposureSource::Estimated;
  CHECK(judged(scene, std::move(estimated)).warnings.front().find("same exposure and give no HDR") !=
        std::string::npos);
}

TEST_CASE("frames that differ in digital gain alone have different exposures", "[capture]") {
  const auto scene = scene_of({0.004});
  const auto with_gains = [&](double even, double odd) {
    auto frames = filmed(scene, 12);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      frames[i].codes.fill(0);  // the pictures say nothing
      frames[i].facts.digital_gain = i % 2 == 0 ? even : odd;
    }
    return judged(scene, std::move(frames)).warnings;
  };
  CHECK(with_gains(1, 4).empty());
  const auto same = with_gains(2, 2);
  REQUIRE(same.size() == 1);
  CHECK(same.front().find("all 12 frames have the same exposure, 4 ms x 2,") == 0);
}

TEST_CASE("frames of unknown exposure are left out of what is said about equal exposures", "[capture]") {
  const auto unknown_up_to = [](const test::MovingScene& scene, int count) {
    auto frames = filmed(scene, 12);
    for (int i = 0; i < 12; ++i) {
      RawFrame& frame = frames[static_cast<std::size_t>(i)];
      frame.codes.fill(0);  // the pictures say nothing
      if (i >= count) continue;
      frame.facts.exposure_s = std::nan("");
      frame.facts.exposure_source = ExposureSource::Unknown;
    }
    return judged(scene, std::move(frames));
  };
  const auto cycle = scene_of({0.001, 0.004, 0.016}), one = scene_of({0.004});
  CHECK(unknown_up_to(cycle, 1).warnings.empty());
  CHECK(unknown_up_to(cycle, 12).warnings.empty());
  const Judged result = unknown_up_to(one, 3);
  REQUIRE(result.warnings.size() == 1);
  CHECK(result.warnings.front().find("all 9 frames have the same exposure, 4 ms,") == 0);
}

TEST_CASE("one wrong label among right ones is put right alone", "[capture]") {
  const auto scene = scene_of({0.001, 0.004, 0.016});
  for (const int wrong : {0, 3, 8, 13}) {
    const Judged result =
        judged(scene, with_labels(scene, 24, [&](int i, int) { return i == wrong ? i + 1 : i; }));
    CAPTURE(wrong);
    CHECK(result.counters.relabelled == 1);
    CHECK(result.counters.contradicted == 0);
    REQUIRE_FALSE(result.warnings.empty());
    CHECK(result.warnings.front().find("1 of 24 frames had a wrong exposure and was relabelled") == 0);
    for (const FrameFacts& facts : result.facts) CHECK(facts.exposure_s == true_exposure_s(scene, facts));
    CHECK(result.facts[static_cast<std::size_t>(wrong)].exposure_source == ExposureSource::Photometric);
    CHECK(result.facts[static_cast<std::size_t>(wrong)].slot == wrong % 3);
  }
}

TEST_CASE("a frame that lamps light otherwise than its neighbours keeps the exposure that is stated",
          "[capture]") {
  // The short exposures of these frames in other light than those before and after them.
  const auto in_light = [](const std::map<int, double>& light, ExposureSource source) {
    const auto scene = scene_of({0.001, 0.016});
    auto frames = filmed(scene, 24);
    for (const auto& [i, factor] : light)
      frames[static_cast<std::size_t>(i)].codes = scene_of({0.001 * factor}).frame(i).codes;
    for (RawFrame& frame : frames) frame.facts.exposure_source = source;
    return judged(scene, std::move(frames));
  };
  const Judged declared = in_light({{14, 1.5}}, ExposureSource::Declared);
  CHECK(declared.counters.contradicted == 0);
  CHECK(declared.facts[14].verdict == Verdict::Plausible);
  CHECK(declared.facts[14].exposure_s == 0.001);
  CHECK(declared.warnings.empty());
  CHECK(in_light({{14, 1.5}}, ExposureSource::Estimated).counters.estimated == 24);
  // No lamp makes that much of a difference; and a camera may have exposed otherwise than it says.
  CHECK(in_light({{14, 2.5}}, ExposureSource::Declared).facts[14].verdict == Verdict::Contradicted);
  CHECK(in_light({{14, 1.5}}, ExposureSource::Reported).facts[14].verdict == Verdict::Contradicted);
}

TEST_CASE("under lamps that flicker what a sensor or a driver says of its one exposure stands", "[capture]") {
  constexpr int kFrames = 36, kPerPeriod = 6;
  constexpr double kExposure_s = 0.004;
  const auto contradicted = [](ExposureSource source) {
    auto frames = filmed(scene_of({kExposure_s}), kFrames);
    for (int i = 0; i < kFrames; ++i) {
      const double light = 1 + 0.3 * std::cos(2 * std::numbers::pi * i / kPerPeriod);
      frames[static_cast<std::size_t>(i)].codes = scene_of({kExposure_s * light}).frame(i).codes;
    }
    for (RawFrame& frame : frames) frame.facts.exposure_source = source;
    return judged(scene_of({kExposure_s}), std::move(frames)).counters.contradicted;
  };
  CHECK(contradicted(ExposureSource::Embedded) == 0);
  // A report stands once the light of another frame differed, too.
  CHECK(contradicted(ExposureSource::Reported) <= 4);
  CHECK(contradicted(ExposureSource::Predicted) > kFrames / 3);
}

TEST_CASE("an estimated exposure that the pictures contradict is told in stops, for it has no time",
          "[capture]") {
  const auto scene = scene_of({0.001, 0.016}), brighter = scene_of({0.0025});
  auto frames = filmed(scene, 24);
  frames[14].codes = brighter.frame(14).codes;
  for (RawFrame& frame : frames) frame.facts.exposure_source = ExposureSource::Estimated;
  const Judged result = judged(scene, std::move(frames));
  REQUIRE(result.warnings.size() == 1);
  CHECK(result.warnings.front().ends_with("frame 14: its pictures contradict its exposure of -2.00 EV"));
}

TEST_CASE("asked to be strict, a recording ends at the first exposure that its pictures contradict",
          "[capture]") {
  const auto scene = scene_of({0.001, 0.004, 0.016});
  const Judged wrong = judged(scene, with_labels(scene, 24, [](int i, int) { return i == 13 ? 14 : i; }),
                              Contradiction::Fails);
  REQUIRE(wrong.error);
  CHECK(wrong.error->code == ErrorCode::BadExposure);
  CHECK(wrong.error->message.find("frame 13") != std::string::npos);
  CHECK(wrong.facts.size() == 13);
  CHECK_FALSE(judged(scene, filmed(scene, 24), Contradiction::Fails).error);
}

TEST_CASE("an objection names the file of its frame, where the frame has one of its own", "[capture]") {
  const auto scene = scene_of({0.001, 0.004, 0.016});
  auto frames = with_labels(scene, 24, [](int i, int) { return i == 13 ? 14 : i; });
  RecordingStage stage(std::make_unique<ReelOfStills>(scene.camera(), std::move(frames)),
                       Contradiction::Warns);
  for (CapturedFrame frame; value_of(stage.next(frame));) {
  }
  const std::vector<std::string> warnings = stage.warnings();
  REQUIRE_FALSE(warnings.empty());
  CHECK(warnings.front().find("; frame 13, 'IMG_13.JPG': ") != std::string::npos);
}

TEST_CASE("an exposure longer than its frame lasts is said, and its frame kept", "[capture]") {
  auto scene = scene_of({0.001, 0.004, 0.016});
  scene.framerate_hz = 100;  // 10 ms a frame
  const Judged result = judged(scene, filmed(scene, 12));
  REQUIRE(result.warnings.size() == 1);
  CHECK(result.warnings.front().find("4 of 12 frames state an exposure longer than the frame interval") == 0);
  for (const FrameFacts& facts : result.facts) {
    CHECK(facts.exposure_s == true_exposure_s(scene, facts));
    CHECK(facts.flags == 0);
    if (facts.slot == 2) CHECK(facts.verdict == Verdict::Plausible);
  }
  CHECK(judged(scene, filmed(scene, 12), Contradiction::Fails).error);
}

TEST_CASE("a long first exposure fits its frame although the next one's centre is near", "[capture]") {
  const auto strict = [](double first_s) {
    const auto scene = scene_of({first_s, 0.001});
    auto frames = filmed(scene, 12);
    for (RawFrame& frame : frames) {
      frame.codes.fill(0);  // the pictures say nothing
      frame.facts.timestamp = frame.facts.timestamp + from_seconds(frame.facts.exposure_s / 2);
    }
    return judged(scene, std::move(frames), Contradiction::Fails).error;
  };
  CHECK_FALSE(strict(0.03));
  const auto longer = strict(0.04);
  REQUIRE(longer);
  CHECK(longer->message == "frame 0: an exposure of 0.04 s does not fit the frame interval of 0.0333333 s");
}

TEST_CASE("a long exposure fits its frame where exposures end a frame apart, though its centre comes early",
          "[capture]") {
  const auto strict = [](double last_s) {
    const auto scene = scene_of({0.001, 0.004, last_s});
    auto frames = filmed(scene, 24);
    for (RawFrame& frame : frames) {
      frame.codes.fill(0);  // the pictures say nothing
      frame.facts.timestamp = frame.facts.timestamp + from_seconds(-frame.facts.exposure_s / 2);
    }
    return judged(scene, std::move(frames), Contradiction::Fails).error;
  };
  CHECK_FALSE(strict(0.03));
  const auto longer = strict(0.04);
  REQUIRE(longer);
  CHECK(longer->message == "frame 2: an exposure of 0.04 s does not fit the frame interval of 0.0333333 s");
}

TEST_CASE("what a camera proved stays proved, and what nobody knew is found by the pictures", "[capture]") {
  const auto scene = scene_of({0.001, 0.004, 0.016});
  auto frames = filmed(scene, 24);
  for (RawFrame& frame : frames) frame.facts.verdict = Verdict::Proved;
  FrameFacts& first = frames[0].facts;
  first.exposure_s = 0, first.exposure_source = ExposureSource::Unknown;
  first.verdict = Verdict::Unknown, first.flags = kFrameExposureUnproved;
  const Judged result = judged(scene, std::move(frames));
  CHECK(result.facts[0].exposure_s == 0.001);
  CHECK(result.facts[0].exposure_source == ExposureSource::Photometric);
  CHECK(result.facts[0].flags == 0);
  CHECK(result.counters.proved == 23);
}

TEST_CASE("a first label of its exposure stays, though frames before it without one look the same",
          "[capture]") {
  const auto scene = scene_of({0.001, 0.016});
  auto frames = filmed(scene, 30);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (i % 2 == 0) frames[i].codes.fill(0);  // only the long exposures can be compared
    if (i == 0 || i > 16) continue;
    FrameFacts& facts = frames[i].facts;
    facts.exposure_s = 0, facts.exposure_source = ExposureSource::Unknown;
    facts.verdict = Verdict::Unknown, facts.flags = kFrameExposureUnproved;
  }
  const Judged result = judged(scene, std::move(frames));
  CHECK(result.warnings.empty());
  for (std::size_t i = 17; i < result.facts.size(); ++i) {
    CHECK(result.facts[i].exposure_s == true_exposure_s(scene, result.facts[i]));
    CHECK(result.facts[i].flags == 0);
  }
}

TEST_CASE("labels that were taken from the pictures are not proved by the same pictures", "[capture]") {
  const auto scene = scene_of({0.001, 0.004, 0.016});
  auto frames = filmed(scene, 24);
  for (RawFrame& frame : frames) {
    frame.facts.exposure_source = ExposureSource::Photometric;
    frame.facts.verdict = Verdict::Plausible;
  }
  const Judged result = judged(scene, std::move(frames));
  CHECK(result.counters.plausible == 24);
  for (const FrameFacts& facts : result.facts) CHECK(facts.exposure_s == true_exposure_s(scene, facts));
}

TEST_CASE("where pictures say nothing, a flag of the recording stays", "[capture]") {
  auto scene = scene_of({0.001, 0.004, 0.016});
  auto frames = filmed(scene, 12);
  for (RawFrame& frame : frames) frame.codes.fill(0);
  frames[4].facts.flags = kFrameExposureUnproved;
  frames[4].facts.verdict = Verdict::Contradicted;
  const Judged result = judged(scene, std::move(frames));
  CHECK(result.facts[4].verdict == Verdict::Contradicted);
  CHECK(result.facts[4].flags == kFrameExposureUnproved);
  CHECK(result.facts[5].verdict == Verdict::Plausible);
  CHECK(result.facts[5].flags == 0);
}

}  // namespace
}  // namespace hdrcam
