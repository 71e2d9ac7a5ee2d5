// What a film shows of given frames: which of them, from where, and what fills its holes.
#include "firmware_host/film/virtual_camera.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tests/support/scratch_folder.h"
#include "tests/support/state_estimate.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr int kRows = 48, kCols = 64;
constexpr float kFieldRadiance = 77;

class OneColour final : public FieldSnapshot {
 public:
  void look(const SceneView& view, WorkerPool&, FieldPicture& picture) const override {
    picture.radiance.reshape(3, view.rows, view.cols), picture.radiance.fill(kFieldRadiance);
    picture.depth.reshape(1, view.rows, view.cols), picture.depth.fill(1);
  }
};

class OneColourField final : public SceneField {
 public:
  Result<void> observe(const SceneObservation&) override { return {}; }
  FitReport fit(const FitBudget&) override { return {}; }
  void restart() override {}
  SnapshotHold snapshot() override { return SnapshotHold(colour_); }

 private:
  OneColour colour_;
};

// One colour, seen from x_m, in a world.
struct Recorded {
  double time_s;
  float radiance;
  double x_m = 0;
  int world = 0;
  bool has_pose = true, lost = false;
  std::optional<double> texture_px = {};  // instead of one colour: a texture that moved so far
  float gamma = 2.2f;                     // of the response with which it was estimated
  std::optional<double> edges_px = {};    // or edges that did
  double exposure_s = 0;
  std::optional<ChannelGains> neutral_gains = {};
};

float texture(double x, double y) {
  return static_cast<float>(5 + std::sin(0.9 * x) + std::sin(0.37 * x + 0.5 * y) + std::cos(0.6 * y));
}

// Edges whose pattern repeats only after more pixels than they move by.
float edges(double x, double y) {
  const double one = std::sin(0.25 * (x - 3) + 0.1 * y), other = std::sin(0.17 * (x - 3) - 0.3 * y);
  return static_cast<float>(10 + 4 * std::tanh(4 * one) + 4 * std::tanh(4 * other));
}

struct Shown {
  float radiance;  // at a quarter of the width
  double x_m;      // 0 without a pose
  float hole;      // radiance of what only the field knows; 0 without any
  FrameFacts facts = {};
  std::optional<FramePose> pose = {};
  FrameRecord record = {};
  float middle = 0;  // radiance there
  std::optional<double> recorded_s = {};
};

std::vector<Shown> filmed(const FilmPlan& plan, std::span<const Recorded> recorded) {
  WorkerPool pool(1);
  OneColourField field;
  VirtualCamera camera(plan, std::nullopt, pool);
  std::vector<Shown> shown;
  const VirtualCamera::Show show = [&](HdrFrame& frame, const ExposedFrame&, const FrameRecord& record) {
    Shown& one = shown.emplace_back(
        Shown{frame.radiance.at(0, kRows / 2, kCols / 4), frame.pose ? frame.pose->T_world_camera.t.x() : 0,
              0, frame.facts, frame.pose, record, frame.radiance.at(0, kRows / 2, frame.radiance.cols() / 2),
              frame.recorded_s});
    for (std::size_t i = 0; i < frame.provenance.size(); ++i)
      if (frame.provenance.samples()[i] == static_cast<std::uint8_t>(Provenance::Field))
        one.hole = std::max(one.hole, frame.radiance.samples()[i]);
    return Result<void>{};
  };
  for (const Recorded& seen : recorded) {
    HdrFrame frame;
    frame.facts.timestamp = Instant::from_seconds(seen.time_s);
    frame.facts.exposure_s = seen.exposure_s;
    frame.white = 100;
    frame.neutral_gains = seen.neutral_gains;
    frame.radiance = Image<float>(3, kRows, kCols), frame.radiance.fill(seen.radiance);
    if (seen.texture_px || seen.edges_px)
      for (int c = 0; c < 3; ++c)
        for (int y = 0; y < kRows; ++y)
          for (int x = 0; x < kCols; ++x)
            frame.radiance.at(c, y, x) =
                seen.texture_px ? texture(x - *seen.texture_px, y) : edges(x - *seen.edges_px, y);
    frame.sigma = Image<float>(1, kRows, kCols);
    frame.provenance = Image<std::uint8_t>(1, kRows, kCols);
    frame.pose.emplace().source = PoseSource::Tracked;
    frame.pose->world = seen.world;
    frame.pose->T_world_camera.t.x() = seen.x_m;
    frame.pose->lost = seen.lost;
    const RigidTransform T_world_camera = frame.pose->T_world_camera;
    if (!seen.has_pose) frame.pose.reset();
    frame.facts.exposure_source = ExposureSource::Embedded;
    frame.facts.verdict = Verdict::Proved;
    ExposedFrame input;
    const RadianceState state;
    const Image<float> own_share;
    FrameEstimate estimate = test::estimate_by_state(input, state, own_share);
    estimate.field = FieldNow(&field);
    estimate.world = seen.world;
    estimate.white = frame.white;
    estimate.view.T_world_camera = T_world_camera;
    estimate.view.time_s = seen.time_s;
    estimate.view.lens = {kCols, kCols, kCols / 2.0, kRows / 2.0};
    estimate.view.rows = kRows, estimate.view.cols = kCols;
    REQUIRE(camera.take(frame, estimate, Response::gamma(seen.gamma), show).ok());
  }
  REQUIRE(camera.finish(show).ok());
  CHECK(camera.done());
  return shown;
}

// Moves the view to the right by so much in a second.
ViewPath sideways(double shift) {
  const std::string path = test::scratch_folder("film_sideways") + "/path.csv";
  std::ofstream(path) << "time_s,dx\n0,0\n1," << shift << "\n";
  return ViewPath::read_path(posix_storage(), path).value();
}

FilmPlan planned(double begin_s, int frames, double framerate_hz) {
  FilmPlan plan;
  plan.begin_s = begin_s;
  plan.frames = frames, plan.framerate_hz = framerate_hz;
  plan.width = kCols, plan.height = kRows;
  return plan;
}

}  // namespace

TEST_CASE("a moment of a film counts from the recording's first frame, also where no frame of it is left",
          "[film]") {
  FilmPlan plan = planned(0.5, 2, 4);
  plan.first = Instant::from_seconds(10);
  const Recorded recorded[] = {{10.5, 5}, {10.75, 10}, {11, 20}, {11.25, 40}};
  const std::vector<Shown> shown = filmed(plan, recorded);
  REQUIRE(shown.size() == 2);
  CHECK(shown[0].radiance == 5);
  CHECK(shown[1].radiance == 10);
  CHECK(shown[0].recorded_s == 0.5);
  CHECK(shown[1].recorded_s == 0.75);
}

TEST_CASE("pictures that are exposed anew are stated with their exposure, not with a recorded frame's",
          "[film]") {
  FilmPlan plan = planned(0, 4, 8);
  plan.exposure = GENERATE(0.004, 0.0);  // 0: the reference exposure, here 1 s
  const Recorded recorded[] = {{0, 5}, {0.25, 10}, {0.5, 20}};
  const std::vector<Shown> all = filmed(plan, recorded);
  REQUIRE(all.size() == 4);
  for (const Shown& shown : all) {
    CHECK(shown.facts.exposure_s == (*plan.exposure > 0 ? 0.004 : 1.0));
    CHECK(shown.facts.gain() == 1);
  }
}

TEST_CASE("a shutter angle adds blur, and the exposure that is stated stays the nearest recorded frame's",
          "[film]") {
  FilmPlan plan = planned(0, 4, 10);
  plan.shutter_s = GENERATE(0.0, 0.05);
  const Recorded recorded[] = {{.time_s = 0, .radiance = 5, .exposure_s = 0.001},
                               {.time_s = 0.25, .radiance = 10, .exposure_s = 0.004}};
  const std::vector<Shown> shown = filmed(plan, recorded);
  REQUIRE(shown.size() == 4);
  for (std::size_t i = 0; i < shown.size(); ++i) CHECK(shown[i].facts.exposure_s == (i < 2 ? 0.001 : 0.004));
}

TEST_CASE("a film's frame is exposed anew through the response with which its own picture was estimated",
          "[film]") {
  FilmPlan plan = planned(0, 3, 10);
  plan.exposure = 0;  // the reference exposure
  // The film's second moment waits for a frame under another response, and is nearer to the one before.
  const Recorded recorded[] = {{.time_s = 0, .radiance = 0.25f, .gamma = 1},
                               {.time_s = 0.25, .radiance = 0.25f, .gamma = 2.2f},
                               {.time_s = 0.5, .radiance = 0.25f, .gamma = 2.2f}};
  const std::vector<Shown> shown = filmed(plan, recorded);
  REQUIRE(shown.size() == 3);
  CHECK(shown[1].radiance == Approx(shown[0].radiance));
  CHECK(shown[2].radiance > 1.5f * shown[1].radiance);
}

TEST_CASE("a film's light is neutral where white is, and the codes of pictures exposed anew are the camera's",
          "[film]") {
  FilmPlan plan = planned(0, 1, 10);
  const Recorded recorded[] = {
      {.time_s = 0, .radiance = 0.25f, .gamma = 1, .neutral_gains = ChannelGains{2, 1, 0.5}},
      {.time_s = 0.25, .radiance = 0.25f, .gamma = 1}};
  CHECK(filmed(plan, recorded)[0].radiance == 0.5f);
  plan.exposure = 0;  // the reference exposure
  const float as_camera = filmed(plan, recorded)[0].radiance;
  plan.exposure = std::nullopt;
  const Recorded neutral[] = {{.time_s = 0, .radiance = 0.25f, .gamma = 1},
                              {.time_s = 0.25, .radiance = 0.25f, .gamma = 1}};
  CHECK(filmed(plan, neutral)[0].radiance == 0.25f);
  plan.exposure = 0;
  CHECK(filmed(plan, neutral)[0].radiance == as_camera);
}

TEST_CASE("where tracking began anew, a film's frame has the pose and the picture of the nearest one",
          "[film]") {
  FilmPlan plan = planned(0, 9, 8);
  plan.stabilize = GENERATE(false, true);
  const Recorded recorded[] = {
      {0, 5, 1, 0}, {0.25, 5, 1, 0}, {0.5, 5, 1, 0}, {0.75, 20, 9, 1}, {1, 20, 9, 1}};
  const std::vector<Shown> shown = filmed(plan, recorded);
  REQUIRE(shown.size() == 9);
  for (std::size_t i = 0; i < shown.size(); ++i) {
    CAPTURE(plan.stabilize, i);
    CHECK(shown[i].x_m == Approx(i < 5 ? 1 : 9));
    CHECK(shown[i].radiance == Approx(i < 5 ? 5 : 20));
  }
}

TEST_CASE("the field of another world fills no hole of a film", "[film]") {
  FilmPlan plan = planned(0.125, 2, 2);
  plan.view = ViewPath::parse_view("0.5,0,0").value();
  const Recorded recorded[] = {{0, 5, 0, 0}, {0.5, 5, 0, 1}, {0.75, 5, 0, 1}};
  const std::vector<Shown> shown = filmed(plan, recorded);
  REQUIRE(shown.size() == 2);
  CHECK(shown[0].hole == 0);
  CHECK(shown[1].hole == kFieldRadiance);
}

TEST_CASE("beside a frame without a pose a film's frame has none, and beside a lost one it is lost",
          "[film]") {
  FilmPlan plan = planned(0, 9, 8);
  SECTION("without a pose: the field holds the camera where it was") {
    const Recorded recorded[] = {{0, 5, 1}, {0.25, 5, 2}, {0.5, 5, 2, 0, false}, {0.75, 5, 4}, {1, 5, 5}};
    const std::vector<Shown> shown = filmed(plan, recorded);
    REQUIRE(shown.size() == 9);
    for (std::size_t i = 0; i < shown.size(); ++i) {
      CAPTURE(i);
      const bool beside = i > 2 && i < 6;
      CHECK(shown[i].pose.has_value() == !beside);
      CHECK(shown[i].record.pose.has_value() == !beside);
      if (!beside) CHECK(shown[i].x_m == Approx(1 + 0.5 * static_cast<double>(i)));
    }
  }
  SECTION("lost") {
    const Recorded recorded[] = {
        {0, 5, 1}, {0.25, 5, 2}, {0.5, 5, 3, 0, true, true}, {0.75, 5, 4}, {1, 5, 5}};
    const std::vector<Shown> shown = filmed(plan, recorded);
    REQUIRE(shown.size() == 9);
    for (std::size_t i = 0; i < shown.size(); ++i) {
      CAPTURE(i);
      REQUIRE(shown[i].pose);
      CHECK(shown[i].pose->lost == (i > 2 && i < 6));
    }
  }
}

TEST_CASE("a path is steadied over the frames that have a pose", "[film]") {
  FilmPlan plan = planned(0, 5, 4);
  plan.stabilize = true;
  const Recorded recorded[] = {{0, 5, 3}, {0.25, 5, 3}, {0.5, 5, 0, 0, false}, {0.75, 5, 3}, {1, 5, 3}};
  const std::vector<Shown> shown = filmed(plan, recorded);
  REQUIRE(shown.size() == 5);
  for (std::size_t i = 0; i < shown.size(); ++i) {
    CAPTURE(i);
    REQUIRE(shown[i].pose.has_value() == (i != 2));
    if (shown[i].pose) CHECK(shown[i].x_m == Approx(3));
  }
}

TEST_CASE("the record of a film's frame states how sure its exposure was", "[film]") {
  const Recorded recorded[] = {{0, 5}, {0.25, 10}};
  const std::vector<Shown> all = filmed(planned(0, 3, 8), recorded);
  REQUIRE(all.size() == 3);
  for (const Shown& shown : all) {
    CHECK(shown.record.exposure_source == ExposureSource::Embedded);
    CHECK(shown.record.verdict == Verdict::Proved);
  }
}

TEST_CASE("a film that crops the width has the blur of the whole picture's middle", "[film]") {
  FilmPlan whole = planned(0.125, 1, 4), cropped = whole;
  whole.shutter_s = cropped.shutter_s = 0.25;
  cropped.width = kCols / 4;
  const Recorded recorded[] = {{.time_s = 0, .radiance = 0, .texture_px = 0},
                               {.time_s = 0.25, .radiance = 0, .texture_px = 6}};
  const Shown all = filmed(whole, recorded).front(), part = filmed(cropped, recorded).front();
  CHECK(part.middle == all.middle);
  whole.shutter_s = 0;
  CHECK(all.middle != Approx(filmed(whole, recorded).front().middle).margin(0.05));  // it is blurred
}

TEST_CASE("an exposure about the recording's first frame is as smooth as the motion after it is fast",
          "[film]") {
  FilmPlan plan = planned(0, 1, 2);
  plan.shutter_s = 0.5;
  const Recorded recorded[] = {{.time_s = 0, .radiance = 0, .edges_px = 0},
                               {.time_s = 0.25, .radiance = 0, .edges_px = 6}};
  const std::vector<Shown> moments = filmed(planned(0, 61, 240), recorded);  // sharp ones
  float moving = 0;
  for (const Shown& moment : moments) moving += moment.middle / static_cast<float>(moments.size());
  const float standing = moments.front().middle;  // before the first frame
  CHECK(filmed(plan, recorded).front().middle == Approx((standing + moving) / 2).margin(0.3));
}

TEST_CASE("an exposure over many recorded frames is as smooth as the fastest of their motions needs",
          "[film]") {
  FilmPlan plan = planned(0.25, 1, 1);
  plan.shutter_s = 0.46;
  const Recorded recorded[] = {
      {.time_s = 0, .radiance = 0, .edges_px = 0},   {.time_s = 0.1, .radiance = 0, .edges_px = 0},
      {.time_s = 0.2, .radiance = 0, .edges_px = 6}, {.time_s = 0.3, .radiance = 0, .edges_px = 6},
      {.time_s = 0.4, .radiance = 0, .edges_px = 6}, {.time_s = 0.5, .radiance = 0, .edges_px = 6}};
  const std::vector<Shown> moments = filmed(planned(0.02, 47, 100), recorded);  // sharp ones
  float mean = 0;
  for (const Shown& moment : moments) mean += moment.middle / static_cast<float>(moments.size());
  CHECK(filmed(plan, recorded).front().middle == Approx(mean).margin(0.3));
}

TEST_CASE("a view that a path moves is blurred by its motion, also where time stands still", "[film]") {
  const Recorded recorded[] = {{.time_s = 0, .radiance = 0, .edges_px = 0},
                               {.time_s = 1, .radiance = 0, .edges_px = 0}};
  FilmPlan moments = planned(0, 101, 100);
  moments.frozen = GENERATE(false, true);
  moments.view = sideways(24.0 / kCols);  // by 24 pixels, at the field's depth of 1
  float mean = 0;
  const std::vector<Shown> sharp = filmed(moments, recorded);
  for (std::size_t i = 25; i <= 75; ++i) mean += sharp[i].middle / 51;
  FilmPlan plan = moments;
  plan.frames = 2, plan.framerate_hz = 2, plan.shutter_s = 0.5;
  CAPTURE(plan.frozen);
  CHECK(filmed(plan, recorded)[1].middle == Approx(mean).margin(0.3));
  CHECK(sharp[50].middle != Approx(mean).margin(0.5));
}

TEST_CASE("where a path is filmed in a moment that stands still nothing that was recorded moves", "[film]") {
  FilmPlan plan = planned(0.125, 1, 4);
  plan.frozen = true;
  plan.view = sideways(0);
  const Recorded recorded[] = {{.time_s = 0, .radiance = 0, .texture_px = 0},
                               {.time_s = 0.25, .radiance = 0, .texture_px = 6}};
  const float sharp = filmed(plan, recorded).front().middle;
  plan.shutter_s = 0.25;
  CHECK(filmed(plan, recorded).front().middle == Approx(sharp));
  plan.view = {};
  CHECK(filmed(plan, recorded).front().middle != Approx(sharp).margin(0.05));  // a photograph
}
