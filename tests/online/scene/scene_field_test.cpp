// The seam of the field: a snapshot stays as it was, and a field that is nothing like hash grids fits it too.
#include "online/scene/scene_field.h"

#include <algorithm>
#include <cstring>
#include <numbers>
#include <thread>
#include <utility>

#include "hal/sections/section_file.h"
#include "online/scene/scene_fields.h"
#include "render/render_stage.h"
#include "tests/online/scene/hash_grid/fit/fit_stream.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/state_estimate.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

int wanted = 0;  // pixels that any view of OneColour was asked for

// One colour, the mean of what the state knows, one metre in front of every camera.
class OneColour final : public SceneField {
 public:
  Result<void> observe(const SceneObservation& seen) override {
    for (int c = 0; c < 3; ++c) {
      double sum = 0;
      for (int y = 0; y < seen.state.radiance.rows(); ++y)
        for (int x = 0; x < seen.state.radiance.cols(); ++x)
          sum += static_cast<double>(seen.state.radiance.at(c, y, x));
      target_[c] = static_cast<float>(sum / static_cast<double>(seen.state.radiance.plane_size()));
    }
    return {};
  }
  FitReport fit(const FitBudget& budget) override {
    FitReport report;
    for (; report.steps < budget.steps; ++report.steps)
      for (int c = 0; c < 3; ++c) colour_[c] += 0.5f * (target_[c] - colour_[c]);
    report.losses.push_back({"colour", static_cast<double>(std::abs(target_[0] - colour_[0]))});
    return report;
  }
  void restart() override { std::fill_n(colour_, 3, 0.f); }
  SnapshotHold snapshot() override {
    for (Snapshot& snapshot : snapshots_)
      if (!snapshot.is_held()) {
        std::copy_n(colour_, 3, snapshot.colour);
        return SnapshotHold(snapshot);
      }
    FAIL("more than two snapshots are held");
    return {};
  }

 private:
  struct Snapshot final : FieldSnapshot {
    float colour[3] = {0, 0, 0};
    void look(const SceneView& view, WorkerPool&, FieldPicture& picture) const override {
      wanted += view.wanted == nullptr
                    ? view.rows * view.cols
                    : static_cast<int>(std::ranges::count(view.wanted->samples(), std::uint8_t{1}));
      picture.radiance.reshape(3, view.rows, view.cols);
      for (int c = 0; c < 3; ++c)
        std::fill_n(picture.radiance.plane(c), picture.radiance.plane_size(), colour[c]);
      for (Image<float>* plane : {&picture.depth, &picture.confidence}) {
        plane->reshape(1, view.rows, view.cols);
        plane->fill(plane == &picture.depth ? 1.f : 0.f);
      }
      for (Image<float>& flow : picture.flow) flow.reshape(2, view.rows, view.cols), flow.fill(0);
    }
  };
  float target_[3] = {0, 0, 0}, colour_[3] = {0, 0, 0};
  Snapshot snapshots_[2];
};

// A stream of frames as the online part would tell a field of them.
struct Told {
  FitStream scene;
  ExposedFrame frame;
  RadianceState state;
  StateMotion motion;
  CameraPose pose;
  DepthMap depth;

  void take(SceneField& field, int i, bool forgetful = false) {
    const FieldObservation seen = scene.frame(i, 0.05f, forgetful);
    frame.index = i;
    frame.exposure = seen.exposure;
    frame.facts.timestamp = Instant::from_seconds(i / 30.);
    frame.codes.copy_from(scene.codes);
    state.radiance.copy_from(scene.radiance);
    state.variance.copy_from(scene.variance);
    state.own_share.reshape(1, scene.rows, scene.cols), state.own_share.fill(1);
    if (i > 0)
      for (auto [to, from] : {std::pair{&motion.to_previous, &scene.to_previous},
                              std::pair{&motion.from_previous, &scene.from_previous}})
        to->vectors.copy_from(from->vectors), to->confidence.copy_from(from->confidence);
    REQUIRE(field.observe({frame, state, unseen_variance_from(4), motion, pose, depth, scene.response}).ok());
  }
  SceneView view(int rows_step = 1) const {
    SceneView full;
    full.time_s = frame.facts.timestamp.seconds();
    full.rows = scene.rows, full.cols = scene.cols;
    full.lens = {1.0 * scene.cols, 1.0 * scene.cols, 0.5 * scene.cols, 0.5 * scene.rows};
    return reduced(full, rows_step);
  }
  // Of the newest frame, with the field as it was fitted.
  FrameEstimate estimate(SceneField& field, const FitReport& fit) const {
    FrameEstimate estimate = test::estimate_by_state(frame, state, state.own_share);
    estimate.field = FieldNow(&field), estimate.fit = &fit;
    estimate.view = view();
    estimate.white = 4, estimate.unseen_variance = unseen_variance_from(4);
    return estimate;
  }
  std::unique_ptr<SceneField> hash_grid(WorkerPool& pool) const {
    return make_scene_field(FieldKind::HashGrid, FitStream::small_options(),
                            {view().lens, scene.rows, scene.cols, 1}, pool);
  }
};

bool same(const Image<float>& a, const Image<float>& b) {
  return a.same_shape(b) && std::memcmp(a.plane(0), b.plane(0), a.size() * sizeof(float)) == 0;
}

// Written to a file in that folder and read again.
Result<std::unique_ptr<FieldSnapshot>> saved_and_loaded(const SnapshotHold& held, const std::string& folder) {
  constexpr SectionFormat kFormat{.what = "a field",
                                  .magic = {'f', 'i', 'e', 'l', 'd', ' ', ' ', ' '},
                                  .version = 1,
                                  .mend = "save it again"};
  const std::string path = test::scratch_folder(folder) + "/field";
  FileInMaking making = TRY(FileInMaking::beside(posix_storage(), path));
  SectionWriter writer = TRY(SectionWriter::create(std::move(making), kFormat));
  REQUIRE(held->save(writer).ok());
  REQUIRE(writer.finish().ok());
  auto reader = SectionReader::open(posix_storage(), path, kFormat);
  REQUIRE(reader.ok());
  auto loaded = load_field(*reader, nullptr);
  if (loaded) CHECK(reader->end_of_file().ok());
  return loaded;
}

}  // namespace

TEST_CASE("a snapshot that is held stays as it was, whatever the field learns meanwhile", "[field]") {
  const double step =
      GENERATE(0., 0.3);  // of the camera, near planes a frame: parallax moves guides and anchor
  WorkerPool pool(1);
  Told told;
  const auto field = told.hash_grid(pool);
  FitBudget budget = FitStream::small_budget();
  const auto take = [&](int i) {
    told.pose.T_world_camera.t = {step * i, 0, 0};
    told.take(*field, i), field->fit(budget);
  };
  const auto view_now = [&] {
    SceneView view = told.view();
    view.T_world_camera = told.pose.T_world_camera;
    return view;
  };
  for (int i = 0; i < 3; ++i) take(i);
  const SnapshotHold held = field->snapshot();
  const SceneView view = view_now();
  FieldPicture before, after, now;
  held->look(view, pool, before);
  budget.steps = 20;
  for (int i = 3; i < 12; ++i) take(i);  // longer than the window
  held->look(view, pool, after);
  field->snapshot()->look(view_now(), pool, now);
  CHECK(same(before.radiance, after.radiance));
  CHECK(same(before.depth, after.depth));
  CHECK(same(before.flow[0], after.flow[0]));
  CHECK_FALSE(same(before.radiance, now.radiance));
}

TEST_CASE(
    "a snapshot that is saved and loaded shows what it showed, from any view and at any time, to the bit",
    "[field]") {
  const double step = GENERATE(0., 0.3);  // of the camera, near planes a frame
  WorkerPool pool(1);
  Told told;
  const auto field = told.hash_grid(pool);
  FitBudget budget = FitStream::small_budget();
  budget.steps = 10;
  for (int i = 0; i < 9; ++i) {
    told.pose.T_world_camera.t = {step * i, 0, 0};
    told.take(*field, i), field->fit(budget);
  }
  const SnapshotHold held = field->snapshot();
  const auto loaded = saved_and_loaded(held, "field_saved");
  REQUIRE(loaded.ok());
  for (const double aside : {0., 0.2})
    for (const double earlier_s : {0., 0.015, 0.1}) {
      CAPTURE(aside, earlier_s);
      SceneView view = told.view();
      view.T_world_camera = told.pose.T_world_camera;
      view.T_world_camera.t.x() += aside;
      view.time_s -= earlier_s;
      FieldPicture before, after;
      held->look(view, pool, before);
      loaded.value()->look(view, pool, after);
      CHECK(same(before.radiance, after.radiance));
      CHECK(same(before.depth, after.depth));
      CHECK(same(before.flow[0], after.flow[0]));
      CHECK(same(before.flow[1], after.flow[1]));
      CHECK(same(before.confidence, after.confidence));
    }
}

TEST_CASE(
    "a snapshot is read again though its last frame was seen from elsewhere, with its back to the others",
    "[field]") {
  WorkerPool pool(1);
  Told told;
  const auto field = told.hash_grid(pool);
  FitBudget budget = FitStream::small_budget();
  budget.steps = 2;
  for (int i = 0; i < 9; ++i) {
    if (i == 8) told.pose.T_world_camera = {rotation({0, std::numbers::pi, 0}), {100, 0, 0}};
    told.take(*field, i), field->fit(budget);
  }
  const SnapshotHold held = field->snapshot();
  const auto loaded = saved_and_loaded(held, "field_turned");
  REQUIRE(loaded.ok());
  SceneView view = told.view();
  view.T_world_camera = told.pose.T_world_camera;
  FieldPicture before, after;
  held->look(view, pool, before);
  loaded.value()->look(view, pool, after);
  CHECK(same(before.radiance, after.radiance));
}

TEST_CASE("one thread looks while another fits, and sees what it would have seen alone", "[field]") {
  WorkerPool fitting(1), looking(1);
  Told told;
  const auto field = told.hash_grid(fitting);
  FitBudget budget = FitStream::small_budget();
  budget.steps = 10;
  told.take(*field, 0), field->fit(budget);
  FieldPicture alone, beside;
  for (int i = 1; i < 8; ++i) {
    told.take(*field, i), field->fit(budget);
    SnapshotHold held = field->snapshot();
    const SceneView view = told.view();
    held->look(view, looking, alone);
    std::thread looker([&, held = std::move(held)] {
      for (int k = 0; k < 3; ++k) held->look(view, looking, beside);
    });
    told.take(*field, ++i), field->fit(budget);
    looker.join();
    CHECK(same(alone.radiance, beside.radiance));
    CHECK(same(alone.depth, beside.depth));
  }
}

TEST_CASE("holding a snapshot does not change it, nor what the field learns", "[field]") {
  WorkerPool pool(1);
  const auto picture = [&pool](bool holds) {
    Told told;
    const auto field = told.hash_grid(pool);
    std::vector<SnapshotHold> held;
    FieldPicture first, now;
    FitBudget budget = FitStream::small_budget();
    budget.steps = 5;
    const SceneView view = told.view();
    for (int i = 0; i < 8; ++i) {
      told.take(*field, i), field->fit(budget);
      if (holds) held.push_back(field->snapshot());
      if (holds && i == 0) held.front()->look(view, pool, first);
    }
    if (holds) {
      held.front()->look(view, pool, now);
      CHECK(same(first.radiance, now.radiance));
    }
    field->snapshot()->look(told.view(), pool, now);
    return now.radiance.clone();
  };
  CHECK(same(picture(false), picture(true)));
}

TEST_CASE("each step that a budget grants is taken, frame by frame", "[field]") {
  WorkerPool pool(1);
  Told told;
  const auto field = told.hash_grid(pool);
  const FitBudget budgets[] = {{0, 32, 4, 4}, {7, 64, 4, 4}, {3, 128, 16, 16}, {1, 32, 1, 1}, {5, 64, 4, 4}};
  for (int i = 0; i < 5; ++i) {
    told.take(*field, i);
    const FitReport report = field->fit(budgets[i]);
    CHECK(report.steps == budgets[i].steps);
    CHECK(report.rolled_back == 0);
    CHECK(report.losses.empty() == (budgets[i].steps == 0));
  }
}

TEST_CASE(
    "an interval takes the steps at the first frame and at each n-th after it, and anew after a restart",
    "[field]") {
  WorkerPool pool(1);
  Told told;
  const auto field = told.hash_grid(pool);
  const FitBudget budget{.steps = 2, .rays_per_step = 32, .interval = 3};
  const auto steps_at = [&](int i) {
    told.take(*field, i);
    return field->fit(budget).steps;
  };
  for (const int first : {0, 7}) {
    field->restart();
    for (int i = 0; i < 7; ++i) CHECK(steps_at(first + i) == (i % 3 == 0 ? 2 : 0));
  }
}

TEST_CASE("a view with half the pixels sees what lies between, a longer exposure blurs what moves",
          "[field]") {
  WorkerPool pool(1);
  Told told;
  told.scene.speed_px = 4;
  const auto field = told.hash_grid(pool);
  for (int i = 0; i < 4; ++i) told.take(*field, i), field->fit({0, 32, 4, 4});
  const SnapshotHold held = field->snapshot();
  FieldPicture sharp, blurred;
  SceneView view = told.view();
  view.time_s -= 1 / 30.;  // a neighbour on both sides
  held->look(view, pool, sharp);
  view.exposure_s = 1 / 30.;
  held->look(view, pool, blurred);
  CHECK(same(sharp.depth, blurred.depth));
  // at frame 2 the square spans 12..23: its front edge is sharp in an instant and a ramp over an interval
  const auto step_at = [](const FieldPicture& picture, int x) {
    return picture.radiance.at(1, 14, x) - picture.radiance.at(1, 14, x + 1);
  };
  CHECK(step_at(sharp, 23) > 1);
  CHECK(step_at(blurred, 23) < 0.7f * step_at(sharp, 23));
  FieldPicture half;
  held->look(told.view(2), pool, half);
  CHECK(half.radiance.cols() == told.scene.cols / 2);
  CHECK(half.radiance.rows() == told.scene.rows / 2);
  // at frame 3 the square spans 16..27 and 8..19
  REQUIRE(told.scene.on_square(3, 10, 18));
  for (const int y : {5, 8})
    for (const int x : {9, 12})
      CHECK(half.radiance.at(1, y, x) == Approx(told.scene.truth(3, 1, 10, 18)).epsilon(0.02));
  for (const auto& [y, x] : {std::pair(2, 3), std::pair(6, 6), std::pair(6, 15), std::pair(12, 10)})
    CHECK(half.radiance.at(1, y, x) < 0.4f);
}

TEST_CASE("a view of the pixels that are wanted shows them as the whole view does", "[field]") {
  WorkerPool pool(2);
  Told told;
  const auto field = told.hash_grid(pool);
  for (int i = 0; i < 4; ++i) told.take(*field, i), field->fit({5, 32, 4, 4});
  SceneView view = told.view();
  FieldPicture whole, part;
  field->snapshot()->look(view, pool, whole);
  Image<std::uint8_t> asked(1, view.rows, view.cols);
  for (std::size_t i = 0; i < asked.size(); ++i) asked.samples()[i] = i % 7 == 3 || i % 40 < 4;
  view.wanted = &asked;
  field->snapshot()->look(view, pool, part);
  for (std::size_t i = 0; i < asked.size(); ++i) {
    REQUIRE(part.radiance.samples()[i] == (asked.samples()[i] != 0 ? whole.radiance.samples()[i] : 0));
    REQUIRE(part.depth.samples()[i] == (asked.samples()[i] != 0 ? whole.depth.samples()[i] : 0));
  }
}

TEST_CASE("merged asks the field for what it fills only, and for all where depth is wanted", "[field]") {
  WorkerPool pool(1);
  Told told;
  OneColour field;
  told.take(field, 0);
  const FitReport fit = field.fit({1, 32, 1, 1});
  FrameBudget budget;
  budget.fills = true, budget.render_step = 2;
  DepthMap known{Image<float>(1, 1, 1), Image<float>(1, 1, 1)};
  known.weight.fill(1);
  HdrFrame frame;
  const auto asked = [&](DepthLayer depth) {
    wanted = 0;
    FrameEstimate estimate = told.estimate(field, fit);
    estimate.budget = budget, estimate.depth = &known;
    RenderStage({.layer = EmitLayer::Merged, .depth = depth}, pool).render(estimate, frame);
    return wanted;
  };
  told.state.variance.fill(1e-4f);
  CHECK(asked(DepthLayer::None) == 0);
  CHECK(frame.depth.empty());
  told.state.variance.at(1, 10, 11) = kUnseenVariance;
  CHECK(asked(DepthLayer::None) == 4);  // that the bilinear value there is made of
  const int quarter = (told.scene.rows / 2) * (told.scene.cols / 2);
  CHECK(asked(DepthLayer::Whole) == quarter);
  CHECK(frame.depth.rows() == told.scene.rows);
  CHECK(asked(DepthLayer::Glance) < quarter / 4);
  CHECK(frame.depth.cols() == told.scene.cols);
  budget.fills = false;
  CHECK(asked(DepthLayer::None) == 0);
}

TEST_CASE("a field that is nothing like hash grids is emitted through the same seam", "[field]") {
  WorkerPool pool(1);
  Told told;
  OneColour field;
  for (int i = 0; i < 3; ++i) told.take(field, i, true);
  const FitReport fit = field.fit({20, 32, 1, 1});
  CHECK(fit.losses[0].value < 1e-3);
  for (float& v : told.state.variance.samples()) v = kUnseenVariance;  // nobody saw anything
  told.state.radiance.fill(0.01f);                                     // at least this bright
  RenderStage stage({.layer = EmitLayer::Merged, .largest_field_ratio = 1000}, pool);
  HdrFrame frame;
  FrameEstimate estimate = told.estimate(field, fit);
  estimate.budget.fills = true;
  stage.render(estimate, frame);
  REQUIRE(frame.radiance.size() > 0);
  for (int c = 0; c < 3; ++c)
    for (int x = 0; x < frame.radiance.cols(); ++x)
      CHECK(frame.radiance.at(c, 5, x) == Approx(frame.radiance.at(c, 20, 7)));
  CHECK(frame.radiance.at(1, 5, 5) == Approx(std::sqrt(0.01f * 0.193f)).epsilon(0.05));  // half of the stops
  CHECK(frame.provenance.at(0, 5, 5) == static_cast<std::uint8_t>(Provenance::Field));
}
