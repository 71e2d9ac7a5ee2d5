// Clips that break estimators: nothing that leaves may be NaN, infinite or negative, whatever comes in, and
// where the answer is known, it is right.
#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "firmware_host/run/pipeline.h"
#include "tests/support/moving_scene.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

PipelineOptions few_steps() {
  PipelineOptions options = options_of(Preset::Fast, EmitLayer::Merged);
  options.knobs.budget.fit.steps = 2;
  return options;
}

void require_fit_to_be_emitted(const HdrFrame& frame) {
  for (const float l : frame.radiance.samples()) REQUIRE((std::isfinite(l) && l >= 0));
  for (const float s : frame.sigma.samples()) REQUIRE((std::isfinite(s) && s >= 0));
  for (const float d : frame.depth.samples()) REQUIRE(std::isfinite(d));
  for (const float v : frame.flow.samples()) REQUIRE(std::isfinite(v));
}

struct Emitted {
  int index = 0;  // of the frame among those taken
  std::uint64_t sequence = 0;
  float white = 1;
  Image<float> radiance, sigma;
  Image<std::uint8_t> provenance;

  double share(Provenance from) const {
    const auto all = provenance.samples();
    return static_cast<double>(std::count(all.begin(), all.end(), static_cast<std::uint8_t>(from))) /
           static_cast<double>(all.size());
  }
};

// The whole pipeline, field included, on what `change` makes of each frame; false: the frame is missing.
std::vector<Emitted> emitted(const CameraFacts& camera, const test::MovingScene& scene, int frames,
                             const std::function<bool(RawFrame&, int)>& change) {
  WorkerPool pool(2);
  Pipeline pipeline(few_steps(), camera, pool);
  std::vector<Emitted> all;
  int taken = 0;
  const Pipeline::Deliver deliver = [&](const HdrFrame& frame, const FrameEstimate&,
                                        const FrameRecord&) -> Result<void> {
    require_fit_to_be_emitted(frame);
    all.push_back({static_cast<int>(all.size()), frame.facts.sequence, frame.white, frame.radiance.clone(),
                   frame.sigma.clone(), frame.provenance.clone()});
    return {};
  };
  for (int i = 0; i < frames; ++i) {
    RawFrame raw = scene.frame(i);
    if (!change(raw, i)) continue;
    REQUIRE(pipeline.take(raw, deliver).ok());
    ++taken;
  }
  REQUIRE(pipeline.finish(deliver).ok());
  REQUIRE(static_cast<int>(all.size()) == taken);
  return all;
}

std::vector<Emitted> emitted(
    const test::MovingScene& scene, int frames,
    const std::function<bool(RawFrame&, int)>& change = [](RawFrame&, int) { return true; }) {
  return emitted(scene.camera(), scene, frames, change);
}

// Mean |log2| between a frame's green and the scene's where that does not clip, stops, after the median
// ratio: the response leaves one gain open.
double log_error(const Emitted& frame, const test::MovingScene& scene) {
  std::vector<double> logs;
  for (int y = 0; y < scene.rows; ++y)
    for (int x = 0; x < scene.cols; ++x) {
      const double truth = scene.radiance(static_cast<int>(frame.sequence), 1, x, y);
      if (truth > 1) continue;
      logs.push_back(std::log2((static_cast<double>(frame.radiance.at(1, y, x)) + 1e-4) / truth));
    }
  const auto middle = logs.begin() + static_cast<std::ptrdiff_t>(logs.size() / 2);
  std::nth_element(logs.begin(), middle, logs.end());
  double sum = 0;
  for (const double e : logs) sum += std::abs(e - *middle);
  return sum / static_cast<double>(logs.size());
}

// From the third frame on, when response and noise have been seen.
void check_error_below(double stops, const std::vector<Emitted>& frames, const test::MovingScene& scene) {
  for (const Emitted& frame : frames) {
    if (frame.index < 2) continue;
    INFO("frame " << frame.sequence);
    CHECK(log_error(frame, scene) < stops);
  }
}

}  // namespace

TEST_CASE("of black pictures the radiance is next to nothing, and no bound is claimed", "[stability]") {
  const auto frames = emitted({}, 9, [](RawFrame& raw, int) { return raw.codes.fill(0), true; });
  for (const Emitted& frame : frames) {
    for (const float l : frame.radiance.samples()) REQUIRE(l < 5e-4f * frame.white);
    CHECK(frame.share(Provenance::Bound) == 0);
  }
}

TEST_CASE("white pictures are at least as bright as the shortest exposure can say", "[stability]") {
  const auto frames = emitted({}, 9, [](RawFrame& raw, int) { return raw.codes.fill(255), true; });
  for (const Emitted& frame : frames) {
    CHECK(frame.white == Approx(4));
    for (const float l : frame.radiance.samples()) REQUIRE(l >= 0.99f * frame.white);
    for (const float s : frame.sigma.samples()) REQUIRE(s > 1);
    CHECK(frame.share(Provenance::Bound) + frame.share(Provenance::Field) == Approx(1));
  }
}

TEST_CASE("a constant radiance, on a linear camera, is that radiance in every frame", "[stability]") {
  test::MovingScene scene;
  CameraFacts camera = scene.camera();
  camera.linear = true;
  constexpr double kExposureCode = 12'000;  // codes per second: 12, 48 and 192
  const auto frames = emitted(camera, scene, 9, [&](RawFrame& raw, int) {
    raw.codes.fill(static_cast<std::uint16_t>(std::lround(kExposureCode * raw.facts.exposure_s)));
    return true;
  });
  for (const Emitted& frame : frames)
    for (const float l : frame.radiance.samples())
      REQUIRE(l == Approx(kExposureCode * 0.004 / 255).epsilon(0.01));
}

TEST_CASE("pictures of one code, whatever the exposure, stay flat", "[stability]") {
  const auto frames = emitted({}, 9, [](RawFrame& raw, int) { return raw.codes.fill(100), true; });
  for (const Emitted& frame : frames)
    for (int c = 0; c < 3; ++c)
      for (std::size_t p = 0; p < frame.radiance.plane_size(); ++p)
        REQUIRE(frame.radiance.plane(c)[p] == Approx(frame.radiance.plane(c)[0]).epsilon(0.01));
}

TEST_CASE("a scene of which there is one exposure alone is right within half a stop", "[stability]") {
  test::MovingScene scene;
  scene.exposures_s = {0.004};
  check_error_below(0.45, emitted(scene, 9), scene);
}

TEST_CASE("a scene that is seen in steps of ten stops is right within a third of a stop", "[stability]") {
  test::MovingScene scene;
  scene.exposures_s = {0.00002, 0.02048};
  check_error_below(0.33, emitted(scene, 10), scene);
}

TEST_CASE("a scene of which each frame has a new exposure is right within a sixth of a stop", "[stability]") {
  test::MovingScene scene;
  scene.exposures_s.clear();
  for (int i = 0; i < 40; ++i) scene.exposures_s.push_back(0.001 * std::exp2(4 * std::sin(i * 1.7)));
  check_error_below(0.16, emitted(scene, 40), scene);
}

TEST_CASE("one moving pixel stays one moving pixel", "[stability]") {
  constexpr double kBackground = 0.05, kPixel = 3;  // radiance
  const test::MovingScene scene;
  const auto code_of = [&](double radiance, double exposure_s) {
    const double light = std::min(1.0, radiance * exposure_s * scene.sensitivity);
    return static_cast<std::uint16_t>(std::lround(255 * std::pow(light, 1 / 2.2)));
  };
  CameraFacts camera = scene.camera();  // a plain background says nothing about the response
  camera.response.assign(3, std::vector<double>(Response::kCodes));
  for (auto& curve : camera.response)
    for (std::size_t z = 0; z < curve.size(); ++z)
      curve[z] = std::pow((static_cast<double>(z) + 0.1) / 255.1, 2.2);
  const auto frames = emitted(camera, scene, 9, [&](RawFrame& raw, int i) {
    raw.codes.fill(code_of(kBackground, raw.facts.exposure_s));
    for (int c = 0; c < 3; ++c) raw.codes.at(c, 24, 3 + 5 * i) = code_of(kPixel, raw.facts.exposure_s);
    return true;
  });
  for (const Emitted& frame : frames) {
    INFO("frame " << frame.index);
    CHECK(frame.radiance.at(1, 5, 5) == Approx(kBackground).epsilon(0.03));
    const bool unclipped = frame.index % 3 == 0;  // only the shortest exposure sees the pixel as it is
    if (unclipped) CHECK(frame.radiance.at(1, 24, 3 + 5 * frame.index) > 0.4 * kPixel);
    if (frame.index > 1)
      CHECK(frame.radiance.at(1, 24, 3 + 5 * (frame.index - 2)) < 1.5 * kBackground);  // no ghost
  }
}

TEST_CASE("a scene of which half of the frames are missing is right within a tenth of a stop",
          "[stability]") {
  const test::MovingScene scene;
  check_error_below(
      0.1,
      emitted(scene, 24,
              [](RawFrame&, int i) { return (static_cast<unsigned>(i) * 2654435761u >> 16 & 1) == 0; }),
      scene);
}

TEST_CASE("timestamps that stand still or run backwards leave a scene right within a sixth of a stop",
          "[stability]") {
  const test::MovingScene scene;
  const auto frames = emitted(scene, 9, [](RawFrame& raw, int i) {
    raw.facts.timestamp = Instant::from_seconds(i % 3 == 0 ? 1.0 : 0.5);
    return true;
  });
  check_error_below(0.16, frames, scene);
}

TEST_CASE("a scene cut in every third frame leaves no ghost of the scene before", "[stability]") {
  // two scenes that share nothing: the drifting one, and the same turned upside down
  const test::MovingScene scene;
  const auto upside_down = [](int i) { return i / 3 % 2 == 1; };
  const auto frames = emitted(scene, 18, [&](RawFrame& raw, int i) {
    if (upside_down(i))
      for (int c = 0; c < 3; ++c)
        std::reverse(raw.codes.plane(c), raw.codes.plane(c) + raw.codes.plane_size());
    return true;
  });
  for (const Emitted& frame : frames) {
    if (frame.index < 6) continue;
    Emitted upright{frame.index, frame.sequence, frame.white, frame.radiance.clone(), {}, {}};
    if (upside_down(frame.index))
      std::reverse(upright.radiance.plane(1), upright.radiance.plane(1) + upright.radiance.plane_size());
    INFO("frame " << frame.index);
    CHECK(log_error(upright, scene) < 0.4);
  }
}

TEST_CASE("exposures that are wrong by one frame leave the radiance in the range of the codes",
          "[stability]") {
  const test::MovingScene scene;
  const auto frames = emitted(scene, 12, [&](RawFrame& raw, int i) {
    raw.facts.exposure_s = scene.exposures_s[static_cast<std::size_t>(i + 1) % 3];
    return true;
  });
  // nothing can be right then, but nothing may leave the range of what a code could mean
  for (const Emitted& frame : frames)
    for (const float l : frame.radiance.samples()) REQUIRE(l <= 4 * frame.white);
}

TEST_CASE("pictures of a few pixels are emitted, and not black", "[stability]") {
  for (const auto& [rows, cols] : {std::pair{1, 1}, {1, 9}, {3, 2}, {7, 8}, {17, 16}}) {
    test::MovingScene scene;
    scene.rows = rows, scene.cols = cols;
    INFO(rows << " x " << cols);
    for (const Emitted& frame : emitted(scene, 8)) {
      REQUIRE(frame.radiance.rows() == rows);
      REQUIRE(frame.radiance.cols() == cols);
      CHECK(*std::max_element(frame.radiance.samples().begin(), frame.radiance.samples().end()) > 0);
    }
  }
}

// Frames that have nothing to do with each other look like noise, by which short exposures tell less than
// longer ones: seven eighths of such a frame are carried where the noise is learned, a tenth where it is not.
TEST_CASE("of random codes the longest exposures stay their own, and no frame is wholly carried",
          "[stability]") {
  std::uint32_t state = 1;
  const auto frames = emitted({}, 9, [&](RawFrame& raw, int) {
    for (auto& code : raw.codes.samples())
      state = state * 1664525u + 1013904223u, code = static_cast<std::uint16_t>(state >> 24);
    return true;
  });
  for (const Emitted& frame : frames) {
    INFO("frame " << frame.index << ": carried " << frame.share(Provenance::Carried) << ", own "
                  << frame.share(Provenance::Own));
    const bool longest = frame.index % 3 == 2;
    if (longest) CHECK(frame.share(Provenance::Own) > 0.5);
    CHECK(frame.share(Provenance::Carried) < 0.95);
  }
}

namespace {

// Many small frames of a still scene, for the state alone or with the field: is the last picture the early
// one?
void does_not_drift(int frames, int size_px, EmitLayer layer) {
  test::MovingScene scene;
  scene.rows = size_px, scene.cols = size_px;
  scene.drift_px = scene.disc_px = 0;
  WorkerPool pool(1);
  PipelineOptions options = options_of(Preset::Fast, layer);
  options.knobs.budget.fit.steps = 1;
  Pipeline pipeline(options, scene.camera(), pool);
  constexpr int kMean = 200;  // frames
  double early = 0, late = 0;
  int emitted = 0;
  bool finite = true;
  const Pipeline::Deliver deliver = [&](const HdrFrame& frame, const FrameEstimate&,
                                        const FrameRecord&) -> Result<void> {
    double sum = 0;
    for (const float l : frame.radiance.samples()) sum += std::log(static_cast<double>(l) + 1e-4);
    for (const float s : frame.sigma.samples()) finite = finite && std::isfinite(s);
    finite = finite && std::isfinite(sum);
    if (emitted >= kMean && emitted < 2 * kMean) early += sum / kMean;
    if (emitted >= frames - kMean) late += sum / kMean;
    ++emitted;
    return {};
  };
  std::vector<RawFrame> cycle;
  for (int i = 0; i < 30; ++i) cycle.push_back(scene.frame(i));
  for (int i = 0; i < frames; ++i) {
    RawFrame& raw = cycle[static_cast<std::size_t>(i % 30)];
    raw.facts.sequence = static_cast<std::uint64_t>(i);
    raw.facts.timestamp = Instant::from_seconds(i / 30.);
    REQUIRE(pipeline.take(raw, deliver).ok());
  }
  REQUIRE(pipeline.finish(deliver).ok());
  CHECK(finite);
  CHECK(emitted == frames);
  const double pixels = 3. * scene.rows * scene.cols;
  INFO("mean ln radiance " << early / pixels << " -> " << late / pixels);
  CHECK(late / pixels == Approx(early / pixels).margin(0.02));
}

}  // namespace

TEST_CASE("two thousand frames of a still scene do not drift", "[stability]") {
  does_not_drift(2000, 16, EmitLayer::State);
}

TEST_CASE("ten thousand small frames of a still scene do not drift", "[stability]") {
  does_not_drift(10'000, 8, EmitLayer::State);
}

TEST_CASE("a hundred thousand frames of a still scene do not drift", "[.][full]") {
  does_not_drift(100'000, 16, EmitLayer::State);
}

TEST_CASE("a hundred thousand frames, field and all, do not drift", "[.][full]") {
  does_not_drift(100'000, 8, EmitLayer::Merged);
}
