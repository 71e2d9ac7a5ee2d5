#include "online/online_stage.h"

#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <string_view>

#include "render/emission.h"
#include "tests/online/online_stream.h"
#include "tests/support/moving_scene.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using test::OnlineStream;
using test::state_alone;

namespace {

struct Run {
  std::vector<std::uint64_t> sequences;
  std::vector<float> radiance;
  Result<void> result;
};

// What is logged while it lives.
class LogKept {
 public:
  LogKept() {
    spdlog::set_default_logger(std::make_shared<spdlog::logger>(
        "kept by a test", std::make_shared<spdlog::sinks::ostream_sink_mt>(said_)));
  }
  ~LogKept() { spdlog::set_default_logger(before_); }
  LogKept(const LogKept&) = delete;
  LogKept& operator=(const LogKept&) = delete;

  int times(std::string_view words) const {
    const std::string said = said_.str();
    int count = 0;
    for (std::size_t at = said.find(words); at != std::string::npos; at = said.find(words, at + 1)) ++count;
    return count;
  }

 private:
  const std::shared_ptr<spdlog::logger> before_ = spdlog::default_logger();
  std::ostringstream said_;
};

Run run(const test::MovingScene& scene, int frames, const Knobs& options, int threads) {
  WorkerPool pool(threads);
  OnlineStream stream(scene.camera(), options, pool);
  Emission emission(pool);
  HdrFrame frame;
  Run run;
  const OnlineStage::Emit emit = [&](const FrameEstimate& estimate) -> Result<void> {
    emission.render(estimate, frame);
    run.sequences.push_back(frame.facts.sequence);
    const auto samples = frame.radiance.samples();
    run.radiance.insert(run.radiance.end(), samples.begin(), samples.end());
    return {};
  };
  for (int i = 0; i < frames; ++i) {
    run.result = stream.take(scene.frame(i), options.budget, emit);
    if (!run.result) return run;
  }
  run.result = stream.finish(options.budget, emit);
  return run;
}

}  // namespace

TEST_CASE("every frame is emitted once and in order, whatever the look-ahead and the length of the clip") {
  const test::MovingScene scene;
  for (const int look_ahead : {0, 1, 2})
    for (const int frames : {2, 3, 6, 7, 11}) {
      Knobs options = state_alone();
      options.look_ahead = look_ahead;
      const Run result = run(scene, frames, options, 1);
      REQUIRE(result.result.ok());
      REQUIRE(result.sequences.size() == static_cast<std::size_t>(frames));
      for (int i = 0; i < frames; ++i)
        CHECK(result.sequences[static_cast<std::size_t>(i)] == static_cast<std::uint64_t>(i));
      for (const float l : result.radiance) REQUIRE((std::isfinite(l) && l >= 0));
    }
}

TEST_CASE("the same frames give the same bytes on one thread and on three, with the field and without") {
  const test::MovingScene scene;
  Knobs options = state_alone();
  CHECK(run(scene, 9, options, 1).radiance == run(scene, 9, options, 3).radiance);
  options.field = FieldKind::HashGrid;
  options.budget.fit.steps = 3;
  CHECK(run(scene, 7, options, 1).radiance == run(scene, 7, options, 3).radiance);
}

TEST_CASE(
    "of the later frames as many join a picture as its budget says, and leave other pictures as they are") {
  const test::MovingScene scene;
  constexpr int kFrames = 14;
  struct Emitted {
    std::vector<float> radiance;
    float most_later = 0;  // largest share of later frames
  };
  const auto emitted = [&](int look_ahead, auto&& joining) {
    Knobs options = state_alone();
    options.look_ahead = look_ahead;
    WorkerPool pool(1);
    OnlineStream stream(scene.camera(), options, pool);
    std::vector<Emitted> frames;
    const OnlineStage::Emit emit = [&](const FrameEstimate& estimate) -> Result<void> {
      const auto radiance = estimate.state.radiance.samples();
      const Image<float>* later = estimate.later_share;
      frames.push_back({{radiance.begin(), radiance.end()},
                        later != nullptr ? *std::ranges::max_element(later->samples()) : 0});
      return {};
    };
    for (int i = 0; i < kFrames; ++i) {
      FrameBudget budget = options.budget;
      budget.later_frames = joining(i);
      REQUIRE(stream.take(scene.frame(i), budget, emit));
    }
    REQUIRE(stream.finish(options.budget, emit));
    REQUIRE(frames.size() == kFrames);
    return frames;
  };
  // To wait longer changes nothing by itself.
  const std::vector<Emitted> wait_one = emitted(1, [](int) { return 0; }),
                             wait_two = emitted(2, [](int) { return 0; });
  for (std::size_t frame = 0; frame < kFrames; ++frame) {
    INFO("frame " << frame);
    CHECK(wait_one[frame].radiance == wait_two[frame].radiance);
  }
  for (const int look_ahead : {1, 2}) {
    const auto by_turns = [&](int call) { return call / 2 % (look_ahead + 1); };
    const std::vector<Emitted> turns = emitted(look_ahead, by_turns);
    std::vector<std::vector<Emitted>> same;  // by the number of later frames
    for (int later = 0; later <= look_ahead; ++later)
      same.push_back(emitted(look_ahead, [&](int) { return later; }));
    for (int i = 7; i < kFrames - look_ahead; ++i) {  // emitted by the call that brings its last later frame
      const auto frame = static_cast<std::size_t>(i);
      INFO("look-ahead " << look_ahead << ", frame " << i);
      CHECK(same[0][frame].most_later == 0);
      for (std::size_t later = 1; later < same.size(); ++later) {
        CHECK(same[later][frame].most_later > 0.05f);
        CHECK(same[later][frame].radiance != same[later - 1][frame].radiance);
      }
      const auto joined = static_cast<std::size_t>(by_turns(i + look_ahead));
      CHECK(turns[frame].radiance == same[joined][frame].radiance);
    }
  }
}

TEST_CASE("without motion blur in their budget, frames are taken for instants") {
  const test::MovingScene scene;
  const auto radiance = [&](bool blurs, bool frozen) {
    Knobs options = state_alone();
    options.look_ahead = 0;
    options.budget.blurs = blurs;
    WorkerPool pool(1);
    OnlineStream stream(scene.camera(), options, pool);
    if (frozen) stream.freeze_exposures();
    std::vector<float> all;
    const OnlineStage::Emit emit = [&](const FrameEstimate& estimate) -> Result<void> {
      const auto samples = estimate.state.radiance.samples();
      all.insert(all.end(), samples.begin(), samples.end());
      return {};
    };
    for (int i = 0; i < 10; ++i) REQUIRE(stream.take(scene.frame(i), options.budget, emit));
    REQUIRE(stream.finish(options.budget, emit));
    return all;
  };
  const std::vector<float> instants = radiance(true, true);
  CHECK(radiance(false, false) == instants);
  CHECK(radiance(true, false) != instants);
}

TEST_CASE("the merged frames are nearer to the scene than the frames that went in") {
  test::MovingScene scene;
  scene.rows = 96, scene.cols = 128;
  const Run result = run(scene, 12, state_alone(), 2);
  REQUIRE(result.result.ok());
  const Response truth = Response::gamma(scene.gamma);
  const std::size_t pixels = static_cast<std::size_t>(scene.rows * scene.cols);
  // both are scaled to the truth by their median ratio: the response leaves one gain open
  const auto log_error = [&](auto&& estimate, int frame) {
    std::vector<double> logs;
    for (int y = 0; y < scene.rows; ++y)
      for (int x = 0; x < scene.cols; ++x)
        logs.push_back(std::log2(std::max(1e-5, estimate(y, x)) / scene.radiance(frame, 1, x, y)));
    auto middle = logs;
    std::nth_element(middle.begin(), middle.begin() + static_cast<std::ptrdiff_t>(middle.size() / 2),
                     middle.end());
    double sum = 0;
    for (const double e : logs) sum += std::abs(e - middle[middle.size() / 2]);
    return sum / static_cast<double>(logs.size());
  };
  for (int i = 3; i < 11; ++i) {
    const RawFrame raw = scene.frame(i);
    const double own = log_error(
        [&](int y, int x) {
          return static_cast<double>(truth.exposure_of(1, static_cast<float>(raw.codes.at(1, y, x)))) /
                 raw.facts.exposure_s;
        },
        i);
    const double merged = log_error(
        [&](int y, int x) {
          return static_cast<double>(result.radiance[(static_cast<std::size_t>(i) * 3 + 1) * pixels +
                                                     static_cast<std::size_t>(y * scene.cols + x)]);
        },
        i);
    INFO("frame " << i << ": own " << own << ", merged " << merged << " stops");
    CHECK(merged < own);
    CHECK(merged < 0.25);
  }
}

TEST_CASE("a frame that is not emitted takes part in the state: the others are the same pictures") {
  const test::MovingScene scene;
  WorkerPool pool(1);
  Emission emission(pool);
  HdrFrame frame;
  const auto pictures = [&](bool all) {
    OnlineStream stream(scene.camera(), state_alone(), pool);
    int left_out = 0;
    stream.online().set_left_out([&] { ++left_out; });
    std::map<std::uint64_t, std::vector<float>> by_sequence;
    const OnlineStage::Emit emit = [&](const FrameEstimate& estimate) -> Result<void> {
      emission.render(estimate, frame);
      by_sequence[frame.facts.sequence].assign(frame.radiance.samples().begin(),
                                               frame.radiance.samples().end());
      return {};
    };
    for (int i = 0; i < 16; ++i) {
      FrameBudget budget;
      budget.emits = all || i < 8 || i % 2 == 0;
      REQUIRE(stream.take(scene.frame(i), budget, emit).ok());
    }
    REQUIRE(stream.finish({}, emit).ok());
    CHECK(left_out == (all ? 0 : 4));
    CHECK(by_sequence.size() == static_cast<std::size_t>(16 - left_out));
    return by_sequence;
  };
  const auto whole = pictures(true), some = pictures(false);
  for (const auto& [sequence, picture] : some) CHECK(picture == whole.at(sequence));
}

TEST_CASE("while the field rests the frames are those of the state, and then it is there again") {
  const test::MovingScene scene;
  WorkerPool pool(1);
  Emission emission(pool);
  HdrFrame frame;
  Knobs options = state_alone();
  const Run alone = run(scene, 20, options, 1);
  options.field = FieldKind::HashGrid;
  options.budget.fit.steps = 2;
  OnlineStream stream(scene.camera(), options, pool);
  std::vector<float> radiance;
  std::string in_field;  // of each frame
  const OnlineStage::Emit emit = [&](const FrameEstimate& estimate) -> Result<void> {
    emission.render(estimate, frame);
    const auto samples = frame.radiance.samples();
    radiance.insert(radiance.end(), samples.begin(), samples.end());
    CHECK((estimate.fit != nullptr) == static_cast<bool>(estimate.field));
    in_field += estimate.field ? 'f' : '-';
    if (estimate.field) {
      FieldPicture view;
      estimate.field->look(estimate.view, pool, view);
      CHECK(std::ranges::all_of(view.radiance.samples(), [](float l) { return std::isfinite(l) && l >= 0; }));
    }
    return {};
  };
  for (int i = 0; i < 20; ++i) {
    FrameBudget budget = options.budget;
    budget.field_rests = i < 7 || (i >= 12 && i < 16);
    REQUIRE(stream.take(scene.frame(i), budget, emit).ok());
  }
  REQUIRE(stream.finish({}, emit).ok());
  CHECK(in_field == "------fffff----fffff");  // the work on a frame is done when the next one is there
  CHECK(radiance == alone.radiance);
}

TEST_CASE("no frame has a stated pose among tracked ones, also where the field rests") {
  const test::MovingScene scene;
  WorkerPool pool(1);
  Knobs options;
  options.look_ahead = 1;
  options.budget.fit.steps = 2;
  OnlineStream stream(scene.camera(), options, pool);
  std::string poses;  // of each frame: tracked, given or none
  const OnlineStage::Emit emit = [&](const FrameEstimate& estimate) -> Result<void> {
    poses += !estimate.pose ? '-' : estimate.pose->source == PoseSource::Tracked ? 't' : 'g';
    return {};
  };
  for (int i = 0; i < 20; ++i) {
    FrameBudget budget = options.budget;
    budget.field_rests = i >= 12 && i < 16;
    RawFrame raw = scene.frame(i);
    if (i > 0) raw.facts.T_world_camera = pose_matrix_of(RigidTransform());
    REQUIRE(stream.take(raw, budget, emit).ok());
  }
  REQUIRE(stream.finish(options.budget, emit).ok());
  CHECK(stream.online().leaves_out_given_poses());
  CHECK(poses == "ttttttttttt----ttttt");
}

TEST_CASE("that a lens is assumed is said once a run, however many worlds it has") {
  const test::MovingScene scene;
  CameraFacts camera = scene.camera();
  camera.intrinsics.reset();
  WorkerPool pool(1);
  Knobs options;
  options.budget.fit.steps = 2;
  OnlineStream stream(camera, options, pool);
  int worlds = 0;
  const OnlineStage::Emit emit = [&](const FrameEstimate& estimate) -> Result<void> {
    worlds = std::max(worlds, estimate.world + 1);
    return {};
  };
  const LogKept log;
  for (int i = 0; i < 20; ++i) {
    FrameBudget budget = options.budget;
    budget.field_rests = i >= 12 && i < 16;
    REQUIRE(stream.take(scene.frame(i), budget, emit).ok());
  }
  REQUIRE(stream.finish(options.budget, emit).ok());
  CHECK(worlds >= 2);
  CHECK(log.times("does not report its focal length") == 1);
}

TEST_CASE("behind a cut the state begins anew, and no frame before it is joined by one behind it") {
  constexpr int kCut = 13;
  test::MovingScene scene, other;
  scene.rows = other.rows = 96, scene.cols = other.cols = 128;
  scene.detail = 0.5, other.detail = 0.7;
  WorkerPool pool(1);
  Knobs options = state_alone();
  options.look_ahead = GENERATE(0, 1, 2);
  CAPTURE(options.look_ahead);
  const Run alone = run(scene, kCut, options, 1);
  OnlineStream stream(scene.camera(), options, pool);
  Emission emission(pool);
  HdrFrame frame;
  std::vector<float> radiance;
  std::string moves;  // from the frame before, of each frame
  float own = 0;      // the largest share of the first frame behind the cut in its own state
  const OnlineStage::Emit emit = [&](const FrameEstimate& estimate) -> Result<void> {
    emission.render(estimate, frame);
    const auto samples = frame.radiance.samples();
    radiance.insert(radiance.end(), samples.begin(), samples.end());
    if (moves.size() == kCut) own = std::ranges::max(estimate.own_share.samples());
    moves += estimate.to_previous != nullptr ? 'm' : '-';
    return {};
  };
  for (int i = 0; i < 2 * kCut; ++i)
    REQUIRE(stream.take((i < kCut ? scene : other).frame(i), options.budget, emit).ok());
  REQUIRE(stream.finish(options.budget, emit).ok());
  CHECK(moves == "-mmmmmmmmmmmm-mmmmmmmmmmmm");
  REQUIRE(radiance.size() == 2 * alone.radiance.size());
  CHECK(std::equal(alone.radiance.begin(), alone.radiance.end(), radiance.begin()));
  CHECK(own > 0.99f);
}

TEST_CASE("behind a cut another world begins, and a fast pan ends none") {
  constexpr int kCut = 14;
  test::MovingScene scene, other;
  scene.rows = other.rows = 96, scene.cols = other.cols = 128;
  scene.detail = 0.5, other.detail = 0.7;
  const bool cuts = GENERATE(true, false);
  CAPTURE(cuts);
  if (!cuts) scene.drift_px = 9;
  WorkerPool pool(1);
  Knobs options;
  options.look_ahead = GENERATE(0, 2);
  OnlineStream stream(scene.camera(), options, pool);
  std::vector<int> worlds;
  std::vector<bool> in_field;
  const OnlineStage::Emit emit = [&](const FrameEstimate& estimate) -> Result<void> {
    worlds.push_back(estimate.world);
    in_field.push_back(static_cast<bool>(estimate.field));
    FieldPicture view;
    estimate.field->look(estimate.view, pool, view);
    CHECK(std::ranges::all_of(view.depth.samples(), [](float z) { return std::isfinite(z) && z > 0; }));
    REQUIRE(estimate.pose);
    CHECK(estimate.pose->world == estimate.world);
    return {};
  };
  for (int i = 0; i < 2 * kCut; ++i)
    REQUIRE(stream.take((cuts && i >= kCut ? other : scene).frame(i), options.budget, emit).ok());
  REQUIRE(stream.finish(options.budget, emit).ok());
  REQUIRE(worlds.size() == 2 * kCut);
  CAPTURE(worlds);
  CHECK(std::ranges::is_sorted(worlds));
  CHECK(worlds[kCut - 1] == 0);
  CHECK(worlds[kCut + 2] == (cuts ? 1 : 0));
  CHECK(worlds.back() == (cuts ? 1 : 0));
  // with look-ahead the last frame before the cut leaves when the next world has begun: with its own field
  CHECK(std::ranges::count(in_field, false) == 0);
}

TEST_CASE(
    "depth is measured at half of a field's resolution where nobody looks, and as asked where it is seen") {
  const test::MovingScene scene;
  const auto grid_step = [&](FieldStep field_step) {
    WorkerPool pool(1);
    Knobs options;
    options.field_step = field_step;
    OnlineStream stream(scene.camera(), options, pool);
    int step = 0;
    const OnlineStage::Emit emit = [&](const FrameEstimate& estimate) -> Result<void> {
      if (estimate.depth != nullptr) step = scene.rows / estimate.depth->inverse_depth.rows();
      return {};
    };
    for (int i = 0; i < 9; ++i) REQUIRE(stream.take(scene.frame(i), options.budget, emit).ok());
    REQUIRE(stream.finish(options.budget, emit).ok());
    return step;
  };
  CHECK(grid_step(FieldStep::One) == DepthOptions().step_px);
  CHECK(grid_step(FieldStep::Auto) == 2 * field_step_px(FieldStep::Auto, scene.rows, scene.cols));
}

TEST_CASE("by day after a night, what every exposure clips is emitted as a bound at the day's light") {
  constexpr float kDay = 4e-6f;
  const test::MovingScene scene;
  WorkerPool pool(1);
  OnlineStage online(state_alone(), scene.camera(), Response::gamma(scene.gamma), pool);
  Emission emission(pool);
  HdrFrame hdr;
  int emitted = 0;
  const OnlineStage::Emit emit = [&](const FrameEstimate& estimate) -> Result<void> {
    emission.render(estimate, hdr);
    INFO("frame " << emitted);
    for (const std::uint8_t from : hdr.provenance.samples())
      REQUIRE(from == static_cast<std::uint8_t>(Provenance::Bound));
    for (const float sigma : hdr.sigma.samples()) REQUIRE(sigma == 10);
    if (emitted++ > 0)
      for (const float l : hdr.radiance.samples()) REQUIRE(l == Approx(1 / kDay).epsilon(1e-3));
    return {};
  };
  for (int i = 0; i < 8; ++i) {
    ExposedFrame frame;
    frame.index = i, frame.exposure = i < 2 ? 1 : kDay, frame.interval_s = 1 / scene.framerate_hz;
    frame.facts.timestamp = Instant::from_seconds(i / scene.framerate_hz);
    frame.codes = Image<float>(3, scene.rows, scene.cols);
    frame.codes.fill(kMaxCode);
    REQUIRE(online.ingest(frame, {}, emit).ok());
  }
  REQUIRE(online.finish(emit).ok());
  CHECK(emitted == 8);
}

TEST_CASE("white is that of the last frames' exposures, also when the light has fallen") {
  constexpr double kFall = 64;
  test::MovingScene day, night;
  night.sensitivity = day.sensitivity / kFall;  // the same codes of longer exposures
  for (double& exposure_s : night.exposures_s) exposure_s *= kFall;
  day.framerate_hz = night.framerate_hz = 0.5;
  WorkerPool pool(1);
  const Knobs options = state_alone();
  OnlineStream stream(day.camera(), options, pool);
  std::vector<float> whites;
  const OnlineStage::Emit emit = [&](const FrameEstimate& estimate) -> Result<void> {
    whites.push_back(estimate.white);
    return {};
  };
  for (int i = 0; i < 60; ++i)
    REQUIRE(stream.take((i < 20 ? day : night).frame(i), options.budget, emit).ok());
  REQUIRE(stream.finish(options.budget, emit).ok());
  REQUIRE(whites.size() == 60);
  CHECK(whites[10] == Approx(4).epsilon(0.01));
  CHECK(whites[25] == Approx(4).epsilon(0.01));  // the state still holds what those exposures showed
  CHECK(whites.back() == Approx(4 / kFall).epsilon(0.01));
}

TEST_CASE("black is what the longest of the last exposures shows black, channel by channel") {
  constexpr float kShort = 0.25f, kLong = 4, kLight = 0.1f;
  constexpr int kBlackCode = 2, kBoth = 12, kFrames = 60;
  const test::MovingScene scene;
  std::array<Response::Curve, 3> inverse{};
  for (std::size_t c = 0; c < 3; ++c)
    inverse[c] = Response::gamma(1.6f + 0.5f * static_cast<float>(c)).inverse(0);
  const Response response(inverse);
  WorkerPool pool(1);
  Knobs options = state_alone();
  options.look_ahead = 0;
  OnlineStage online(options, scene.camera(), response, pool);
  std::vector<std::array<float, 3>> darkest;
  const OnlineStage::Emit emit = [&](const FrameEstimate& estimate) -> Result<void> {
    darkest.push_back(estimate.darkest);
    return {};
  };
  for (int i = 0; i < kFrames; ++i) {
    ExposedFrame frame;
    frame.index = i, frame.exposure = i < kBoth && i % 2 == 1 ? kLong : kShort;
    frame.interval_s = 1 / scene.framerate_hz;
    frame.facts.timestamp = Instant::from_seconds(i / scene.framerate_hz);
    frame.codes = Image<float>(3, scene.rows, scene.cols);
    for (int c = 0; c < 3; ++c)
      std::fill_n(frame.codes.plane(c), frame.codes.plane_size(),
                  response.code_of(c, kLight * frame.exposure));
    REQUIRE(online.ingest(frame, {}, emit).ok());
  }
  REQUIRE(online.finish(emit).ok());
  REQUIRE(darkest.size() == kFrames);
  for (std::size_t c = 0; c < 3; ++c) {
    CAPTURE(c);
    CHECK(darkest[kBoth][c] == Approx(inverse[c][kBlackCode] / kLong).epsilon(0.02));
    CHECK(darkest.back()[c] == Approx(inverse[c][kBlackCode] / kShort).epsilon(0.02));
  }
}

TEST_CASE("a clip of one frame and an exposure that cannot be are errors that name them") {
  test::MovingScene scene;
  const Run one = run(scene, 1, state_alone(), 1);
  REQUIRE_FALSE(one.result.ok());
  CHECK(one.result.error().code == ErrorCode::TooShort);
  for (const double bad : {0., -0.004, std::nan(""), HUGE_VAL}) {
    scene.exposures_s = {0.001, bad};
    scene.full_well = 0;
    const Run refused = run(scene, 3, state_alone(), 1);
    REQUIRE_FALSE(refused.result.ok());
    CHECK(refused.result.error().code == ErrorCode::BadExposure);
    CHECK(refused.result.error().message.find("frame 1") != std::string::npos);
  }
}
