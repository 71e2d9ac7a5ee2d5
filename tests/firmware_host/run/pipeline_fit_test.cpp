// That the product does what its parts can do: the steps of the fit are taken, every loss weighs, the black
// level is removed, the gains and the seed count.
#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "firmware_host/run/pipeline.h"
#include "tests/support/moving_scene.h"
#include "tests/support/response_error.h"

#include "tests/contracts/expect.h"

namespace hdrcam {
namespace {

struct Emitted {
  std::vector<std::vector<float>> radiance;        // of each frame, [rgb, rows, cols]
  std::vector<std::vector<float>> median_flow_px;  // of each frame: along x and y, empty where there is none
  std::vector<FrameRecord> records;
  BlackLevel black_level{};
};

std::vector<float> medians(const Image<float>& image) {
  std::vector<float> all;
  for (int c = 0; c < image.channels(); ++c) {
    std::vector<float> values(image.plane(c), image.plane(c) + image.plane_size());
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    all.push_back(*middle);
  }
  return all;
}

Emitted emitted_by(const std::vector<RawFrame>& frames, const CameraFacts& camera,
                   const PipelineOptions& options) {
  WorkerPool pool(2);
  Pipeline pipeline(options, camera, pool);
  Emitted emitted;
  const Pipeline::Deliver deliver = [&](const HdrFrame& frame, const FrameEstimate&,
                                        const FrameRecord& record) -> Result<void> {
    const auto samples = frame.radiance.samples();
    emitted.radiance.emplace_back(samples.begin(), samples.end());
    emitted.median_flow_px.push_back(medians(frame.flow));
    emitted.records.push_back(record);
    return {};
  };
  for (const RawFrame& frame : frames) require_done(pipeline.take(frame, deliver));
  require_done(pipeline.finish(deliver));
  emitted.black_level = pipeline.online().sensor().camera_black_level();
  return emitted;
}

std::vector<RawFrame> frames_of(const test::MovingScene& scene, int count) {
  std::vector<RawFrame> frames;
  for (int i = 0; i < count; ++i) frames.push_back(scene.frame(i));
  return frames;
}

// The camera of the scene with its response told, as a calibrated recording has it.
CameraFacts calibrated(const test::MovingScene& scene) {
  CameraFacts camera = scene.camera();
  const Response response = Response::gamma(scene.gamma);
  for (int c = 0; c < 3; ++c)
    camera.response.emplace_back(response.inverse(c).begin(), response.inverse(c).end());
  return camera;
}

// Mean |log2| of estimate over truth, of the dark pixels of frame 8; `relative`: up to one gain for all.
double dark_error_stops(const test::MovingScene& scene, const Emitted& emitted, bool relative) {
  std::vector<double> logs;
  double lowest = std::log2(0.06);
  for (int y = 0; y < scene.rows; ++y)
    for (int x = 0; x < scene.cols; ++x) {
      const double truth = std::log2(scene.radiance(8, 1, x, y));
      if (truth > lowest) continue;
      const auto at = static_cast<std::size_t>((scene.rows + y) * scene.cols + x);
      logs.push_back(std::log2(std::max(1e-5, static_cast<double>(emitted.radiance[8][at]))) - truth);
    }
  REQUIRE(logs.size() > 100);
  auto middle = logs.begin() + static_cast<std::ptrdiff_t>(logs.size() / 2);
  std::nth_element(logs.begin(), middle, logs.end());
  const double gain = relative ? *middle : 0;
  double sum = 0;
  for (const double log : logs) sum += std::abs(log - gain);
  return sum / static_cast<double>(logs.size());
}

TEST_CASE("a stated response is the same in any unit of exposure") {
  const test::MovingScene scene;
  const Response truth = Response::gamma(scene.gamma);
  WorkerPool pool(1);
  for (const double unit : {1e-6, 1., 1e6}) {
    CameraFacts camera = calibrated(scene);
    for (auto& curve : camera.response)
      for (double& exposure : curve) exposure *= unit;
    const Pipeline pipeline(options_of(Preset::Realtime, EmitLayer::State), camera, pool);
    CHECK(test::response_error(pipeline.online().sensor().response(), truth) < 1e-3);
  }
}

TEST_CASE("a field that is shown takes the steps of its preset on every frame, and they change its picture") {
  const test::MovingScene scene;
  const auto frames = frames_of(scene, 8);
  for (const Preset preset : {Preset::Fast, Preset::Balanced}) {
    CAPTURE(name(preset));
    PipelineOptions options = options_of(preset, EmitLayer::Field);
    const int steps = options.knobs.budget.fit.steps;
    REQUIRE(steps == knobs_of(preset).view_steps);
    const Emitted fitted = emitted_by(frames, scene.camera(), options);
    REQUIRE(fitted.records.size() == frames.size());
    for (const FrameRecord& record : fitted.records) CHECK(record.fit_steps == steps);
    options.knobs.budget.fit.steps = 0;
    CHECK(emitted_by(frames, scene.camera(), options).radiance.back() != fitted.radiance.back());
  }
}

TEST_CASE("every loss that is on by default weighs in the fit of a stream that moves") {
  const test::MovingScene scene;
  const Emitted emitted =
      emitted_by(frames_of(scene, 10), scene.camera(), options_of(Preset::Fast, EmitLayer::Merged));
  std::set<std::string> weighing;
  for (const FrameRecord& record : emitted.records)
    for (const NamedValue& loss : record.losses) {
      CHECK(loss.value > 0);
      weighing.insert(std::string(loss.name));
    }
  for (const char* name : {"combined", "warped", "occlusion", "flow", "cycle", "spatial", "temporal",
                           "minimal", "state", "consistency", "entropy"}) {
    INFO(name);
    CHECK(weighing.contains(name));
  }
}

TEST_CASE("a black level that the camera reports is removed before the fit") {
  test::MovingScene scene;
  scene.full_well = 0;  // no noise: what is left is the pedestal
  const PipelineOptions options = options_of(Preset::Fast, EmitLayer::State);
  const double clean =
      dark_error_stops(scene, emitted_by(frames_of(scene, 10), calibrated(scene), options), false);
  scene.black_level = 24;
  auto frames = frames_of(scene, 10);
  for (RawFrame& frame : frames) frame.facts.black_level = BlackLevel(24);
  const double removed = dark_error_stops(scene, emitted_by(frames, calibrated(scene), options), false);
  for (RawFrame& frame : frames) frame.facts.black_level.reset();
  const double kept = dark_error_stops(scene, emitted_by(frames, calibrated(scene), options), false);
  INFO("dark pixels: " << clean << " stops without a pedestal, " << removed << " with it removed, " << kept
                       << " with it kept");
  CHECK(removed < clean + 0.1);
  CHECK(kept > clean + 0.3);
}

TEST_CASE("a black level that nobody reports is estimated and removed") {
  test::MovingScene scene;
  scene.full_well = 0;
  scene.rows = 96, scene.cols = 128;
  const PipelineOptions options = options_of(Preset::Fast, EmitLayer::State);
  const double clean =
      dark_error_stops(scene, emitted_by(frames_of(scene, 10), scene.camera(), options), true);
  scene.black_level = 24;
  const Emitted emitted = emitted_by(frames_of(scene, 10), scene.camera(), options);
  const double removed = dark_error_stops(scene, emitted, true);
  INFO("dark pixels: " << clean << " stops without a pedestal, " << removed
                       << " with one of 24 codes, of which " << emitted.black_level[1] << " were found");
  CHECK(emitted.black_level[1] > 6);  // how near is of the estimator's own tests
  CHECK(removed < clean + 0.25);
}

TEST_CASE("gain counts as exposure: the same light through time or through gain is the same picture") {
  const test::MovingScene scene;
  auto by_time = frames_of(scene, 8), by_gain = frames_of(scene, 8);
  for (RawFrame& frame : by_gain) {
    // every exposure as long as the shortest, so that the blur is the same, too
    const double factor = frame.facts.exposure_s / scene.exposures_s.front();
    frame.facts.exposure_s = scene.exposures_s.front();
    frame.facts.analogue_gain = std::sqrt(factor), frame.facts.digital_gain = factor / std::sqrt(factor);
  }
  const PipelineOptions options = options_of(Preset::Fast, EmitLayer::State);
  const Emitted time = emitted_by(by_time, scene.camera(), options),
                gain = emitted_by(by_gain, scene.camera(), options);
  for (std::size_t i = 0; i < by_gain.size(); ++i) {
    CHECK(gain.records[i].exposure == Approx(time.records[i].exposure));
    double sum = 0;
    for (std::size_t p = 0; p < gain.radiance[i].size(); ++p)
      sum += std::abs(std::log2(std::max(1e-4f, gain.radiance[i][p]) / std::max(1e-4f, time.radiance[i][p])));
    CHECK(sum / static_cast<double>(gain.radiance[i].size()) < 0.1);
  }
}

TEST_CASE("the preset says how far a run looks ahead, unless the run does") {
  Settings settings;
  CHECK(options_of(settings, FieldUse::None).knobs.look_ahead == Knobs::kAsSizeAllows);
  settings.fit.preset = Preset::Fast;
  CHECK(options_of(settings, FieldUse::None).knobs.look_ahead == 1);
  settings.fit.preset = Preset::Best;
  CHECK(options_of(settings, FieldUse::None).knobs.look_ahead == 2);
  for (const int frames : {0, 1, 2}) {
    settings.fit.knobs["look_ahead"] = std::to_string(frames);
    CHECK(options_of(settings, FieldUse::None).knobs.look_ahead == frames);
  }
}

TEST_CASE("exposures are relative to the geometric mean of the cycle") {
  test::MovingScene scene;
  scene.exposures_s = {0.001, 0.004, 0.032};
  const Emitted emitted =
      emitted_by(frames_of(scene, 6), scene.camera(), options_of(Preset::Fast, EmitLayer::State));
  const double reference_s = std::cbrt(0.001 * 0.004 * 0.032);
  for (std::size_t i = 0; i < 6; ++i)
    CHECK(emitted.records[i].exposure == Approx(scene.exposures_s[i % 3] / reference_s).epsilon(1e-4));
}

TEST_CASE("each pixel says where it came from: own, carried, look-ahead or bound") {
  test::MovingScene scene;
  scene.drift_px = scene.disc_px = 0;
  PipelineOptions options = options_of(Preset::Fast, EmitLayer::State);
  const auto shares = [&](int look_ahead) {
    options.knobs.look_ahead = look_ahead;
    std::vector<std::array<float, kProvenances>> all;
    for (const FrameRecord& record : emitted_by(frames_of(scene, 9), scene.camera(), options).records)
      all.push_back(record.provenance_share);
    return all;
  };
  const auto of = [](const std::array<float, kProvenances>& share, Provenance from) {
    return static_cast<double>(share[static_cast<std::size_t>(from)]);
  };
  const auto causal = shares(0);
  CHECK(of(causal[0], Provenance::Own) + of(causal[0], Provenance::Bound) == Approx(1));
  CHECK(of(causal[0], Provenance::Own) > 0.5);
  CHECK(of(causal[8], Provenance::Carried) > 0.5);
  // a short exposure knows little of the dark; the frame after it is four times as long
  CHECK(of(shares(1)[0], Provenance::LookAhead) > 0.3);
  CHECK(of(causal[0], Provenance::LookAhead) == 0);
  scene.sensitivity = 1e7, scene.full_well = 0;
  CHECK(of(shares(1)[8], Provenance::Bound) == Approx(1));
}

TEST_CASE("the emitted flow leads to the previous frame, where somebody asked for it") {
  test::MovingScene scene;
  scene.rows = 64, scene.cols = 96;
  scene.drift_px = scene.disc_px = 2;
  PipelineOptions options = options_of(Preset::Fast, EmitLayer::State);
  for (const auto& none : emitted_by(frames_of(scene, 4), scene.camera(), options).median_flow_px)
    CHECK(none.empty());  // nobody asked
  options.render.shows_flow_backward = true;
  const Emitted emitted = emitted_by(frames_of(scene, 8), scene.camera(), options);
  CHECK(emitted.median_flow_px.front().empty());
  for (std::size_t i = 3; i < 8; ++i) {
    REQUIRE(emitted.median_flow_px[i].size() == 2);
    CHECK(emitted.median_flow_px[i][0] == Approx(-2).margin(0.3));
    CHECK(emitted.median_flow_px[i][1] == Approx(0).margin(0.3));
  }
}

TEST_CASE("another seed is another fit, the same seed the same one") {
  const test::MovingScene scene;
  const auto frames = frames_of(scene, 7);
  const auto last = [&](int seed) {
    Settings settings;
    settings.fit.preset = Preset::Fast, settings.fit.emit = EmitLayer::Field, settings.fit.seed = seed;
    return emitted_by(frames, scene.camera(), options_of(settings, FieldUse::Fills)).radiance.back();
  };
  const auto one = last(1);
  CHECK(last(1) == one);
  CHECK(last(2) != one);
}

}  // namespace
}  // namespace hdrcam
