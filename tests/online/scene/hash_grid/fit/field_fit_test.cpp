#include "online/scene/hash_grid/fit/field_fit.h"

#include <cstring>
#include <tuple>

#include "online/scene/hash_grid/field/field_renderer.h"
#include "online/scene/hash_grid/fit/ray_drawing.h"
#include "tests/online/scene/hash_grid/fit/fit_stream.h"
#include "tests/support/uniform_flow.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

struct Run {
  WorkerPool pool;
  FitStream scene;
  FieldFit fit;
  FieldRenderer renderer;
  FieldPicture view;
  double last_time_s = 0;

  explicit Run(const FieldOptions& options = FitStream::small_options(), int threads = 1)
      : pool(threads), fit(options, {}, scene.rows, scene.cols, pool) {
    fit.prepare(FitStream::small_budget());
  }

  void take(int i, int steps, bool forgetful = false) {
    const FieldObservation seen = scene.frame(i, 0.05f, forgetful);
    REQUIRE(fit.observe(seen, scene.response).ok());
    last_time_s = seen.time_s;
    for (int s = 0; s < steps; ++s) fit.step();
  }
  const FieldPicture& look(int step = 1) {
    renderer.render(fit.field(), FitStream::view(fit, {}, last_time_s, step), pool, view);
    return view;
  }
};

double log_error(const FitStream& scene, const FieldPicture& view, int i, bool only_square) {
  double sum = 0;
  int count = 0;
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < scene.rows; ++y)
      for (int x = 0; x < scene.cols; ++x) {
        if (only_square && !scene.on_square(i, y, x)) continue;
        sum += std::abs(std::log(static_cast<double>(view.radiance.at(c, y, x)) /
                                 static_cast<double>(scene.truth(i, c, y, x))));
        ++count;
      }
  return sum / count;
}

// A wall, bright up to column 40, behind a near square: the radiance of a hidden place of the wall as a view
// from further right shows it, where the square is 6 px further left and the wall 1.2.
float hidden_place(float speed_px, float earlier_inverse_depth, float wall_flow_px, int column) {
  WorkerPool pool(1);
  FitStream scene;
  scene.speed_px = speed_px;
  FieldFit fit(FitStream::small_options(), Intrinsics{48, 48, 24, 16}, scene.rows, scene.cols, pool);
  Image<float> inverse_depth(1, scene.rows, scene.cols);
  constexpr int kLast = 4;
  for (int i = 0; i <= kLast; ++i) {
    FieldObservation seen = scene.frame(i);
    seen.inverse_depth = &inverse_depth;
    for (int y = 0; y < scene.rows; ++y)
      for (int x = 0; x < scene.cols; ++x) {
        const bool near = scene.on_square(i, y, x);
        inverse_depth.at(0, y, x) = near ? 0.5f : i < kLast ? earlier_inverse_depth : 0.1f;
        if (!near) scene.to_previous.vectors.at(0, y, x) = wall_flow_px;
        for (int c = 0; c < 3; ++c) scene.radiance.at(c, y, x) = near ? 1.5f : x < 40 ? 0.4f : 0.1f;
      }
    REQUIRE(fit.observe(seen, scene.response).ok());
  }
  RigidTransform right;
  right.t.x() = 0.25;
  FieldRenderer renderer;
  FieldPicture view;
  renderer.render(fit.field(), FitStream::view(fit, right, kLast / 30.0, 1), pool, view);
  return view.radiance.at(1, 14, column);
}

}  // namespace

TEST_CASE("a field of zero steps renders the state's picture and the state's motion", "[isa][field]") {
  Run run;
  for (int i = 0; i < 5; ++i) run.take(i, 0);
  const FieldPicture& view = run.look();
  REQUIRE(view.radiance.same_shape(run.scene.radiance));
  for (std::size_t p = 0; p < view.radiance.size(); ++p)
    REQUIRE(view.radiance.samples()[p] == Approx(run.scene.radiance.samples()[p]).epsilon(0.01));
  // on the square, away from its border, the field moves as the prior says
  REQUIRE(run.scene.on_square(4, 14, 14));
  CHECK(view.flow[1].at(0, 14, 14) == Approx(-run.scene.speed_px).margin(0.3));
}

TEST_CASE("networks that are made anew have the fit's lattices, whatever the size and the blocks",
          "[field]") {
  const auto [rows, cols, step] =
      GENERATE(std::tuple(480, 854, 4), std::tuple(180, 320, 8), std::tuple(33, 47, 2));
  CAPTURE(rows, cols, step);
  WorkerPool pool(1);
  FieldOptions options;
  options.step_px = step;
  const FieldFit fit(options, {}, rows, cols, pool);
  const FieldNetworks<float> anew = fit.fresh_networks(1);
  const RadianceField field = fit.field();
  const FieldNetworks<float>& fitted = field.networks;
  for (const auto& [a, b] :
       {std::pair{&anew.static_.grid, &fitted.static_.grid}, {&anew.dynamic.grid, &fitted.dynamic.grid}})
    for (int l = 0; l < a->shape().levels; ++l)
      for (int axis = 0; axis < 3; ++axis) CHECK(a->level(l).cells[axis] == b->level(l).cells[axis]);
}

TEST_CASE("a picture that the camera's motion blurs counts less, though nothing moves in the scene",
          "[field]") {
  constexpr int kRows = 60, kCols = 80;
  WorkerPool pool(1);
  const Intrinsics lens{80, 80, kCols / 2.0, kRows / 2.0};
  FieldFit fit({}, lens, kRows, kCols, pool);
  Image<float> codes(3, kRows, kCols), radiance(3, kRows, kCols), variance(3, kRows, kCols);
  codes.fill(100), radiance.fill(0.4f), variance.fill(1e-4f);
  const FlowField to_previous = test::uniform_flow(kRows, kCols, 5),
                  from_previous = test::uniform_flow(kRows, kCols, -5);
  for (int i = 0; i < 3; ++i) {
    FieldObservation seen;
    seen.index = i, seen.time_s = i / 25.0, seen.blur_fraction = 0.8f;
    seen.codes = &codes, seen.radiance = &radiance, seen.variance = &variance;
    seen.T_world_camera.R = rotation({0, i * 5.0 / 80, 0});
    if (i > 0) seen.to_previous = &to_previous, seen.from_previous = &from_previous;
    REQUIRE(fit.observe(seen, Response::linear()).ok());
  }
  std::vector<PixelPicker> pickers;
  for (int i = 0; i < fit.window().slots(); ++i) {
    pickers.emplace_back(kRows, kCols);
    pickers.back().look_at(fit.window().newest());
    pickers.back().prepare(1);
  }
  std::vector<TrainingRay> rays(4 * kRaysPerShard);
  Pcg32 random(1);
  draw_rays(fit.window(), {0.5f, false}, pickers, random, rays);
  // 5 px a frame, exposed for .8 of it: 4 px, a little more or less towards the corners
  for (const TrainingRay& ray : rays) CHECK(ray.sharpness == Approx(1 / 17.0).epsilon(0.4));
}

TEST_CASE("a field of blocks renders the state's means, and motion in pixels of whoever looks",
          "[isa][field]") {
  FieldOptions options = FitStream::small_options();
  options.step_px = 2;
  Run run(options);
  for (int i = 0; i < 5; ++i) run.take(i, 0);
  const FieldPicture& view = run.look();
  REQUIRE(view.radiance.rows() == run.scene.rows / 2);
  REQUIRE(view.radiance.cols() == run.scene.cols / 2);
  const Image<float>& truth = run.scene.radiance;
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < view.radiance.rows(); ++y)
      for (int x = 0; x < view.radiance.cols(); ++x) {
        const float mean = (truth.at(c, 2 * y, 2 * x) + truth.at(c, 2 * y, 2 * x + 1) +
                            truth.at(c, 2 * y + 1, 2 * x) + truth.at(c, 2 * y + 1, 2 * x + 1)) /
                           4;
        REQUIRE(view.radiance.at(c, y, x) == Approx(mean).epsilon(0.01));
      }
  // on the square, away from its border
  CHECK(view.flow[1].at(0, 7, 7) == Approx(-run.scene.speed_px / 2).margin(0.15));
  SceneView whole;
  whole.time_s = run.last_time_s;
  whole.rows = run.scene.rows, whole.cols = run.scene.cols;
  whole.lens = {1.0 * whole.cols, 1.0 * whole.cols, 0.5 * whole.cols, 0.5 * whole.rows};
  run.renderer.render(run.fit.field(), whole, run.pool, run.view);
  CHECK(run.view.flow[1].at(0, 14, 14) == Approx(-run.scene.speed_px).margin(0.3));
  CHECK(run.view.radiance.at(1, 14, 16) == Approx(run.scene.radiance.at(1, 14, 16)).epsilon(0.01));
}

TEST_CASE("a picture that is no multiple of the blocks keeps its edges", "[isa][field]") {
  const int step = GENERATE(2, 4, 8);
  WorkerPool pool(1);
  FitStream scene;
  scene.rows = 33, scene.cols = 47;
  FieldOptions options = FitStream::small_options();
  options.step_px = step;
  FieldFit fit(options, {}, scene.rows, scene.cols, pool);
  for (int i = 0; i < 4; ++i) REQUIRE(fit.observe(scene.frame(i), scene.response).ok());
  FieldRenderer renderer;
  FieldPicture view;
  renderer.render(fit.field(), FitStream::view(fit, {}, 3 / 30.0, 1), pool, view);
  REQUIRE(view.radiance.rows() == (33 + step - 1) / step);
  REQUIRE(view.radiance.cols() == (47 + step - 1) / step);
  // the corner's block has one row of the picture, which stands for all of them, and all but one of its
  // columns
  float sum = 0;
  for (int x = 0; x < step; ++x)
    sum += scene.radiance.at(0, 32, std::min((view.radiance.cols() - 1) * step + x, 46));
  CHECK(view.radiance.at(0, view.radiance.rows() - 1, view.radiance.cols() - 1) ==
        Approx(sum / static_cast<float>(step)).epsilon(0.01));
}

TEST_CASE("a field of one branch renders all light, and moves only where that is the dynamic one",
          "[field]") {
  for (const Branches branches : {Branches::Static, Branches::Dynamic, Branches::Both}) {
    FieldOptions options = FitStream::small_options();
    options.shape.branches = branches;
    Run run(options);
    for (int i = 0; i < 5; ++i) run.take(i, 20);
    const FieldPicture& view = run.look();
    CHECK(log_error(run.scene, view, 4, false) < 0.02);
    const float on_square = view.flow[1].at(0, 14, 16), beside = view.flow[1].at(0, 28, 40);
    if (branches == Branches::Static)
      for (const float px : view.flow[1].samples()) REQUIRE(std::abs(px) < 1e-4f);
    else
      CHECK(on_square == Approx(-run.scene.speed_px).margin(0.15));
    // what stands is the static branch's, where there is one
    if (branches == Branches::Both) CHECK(std::abs(beside) < 1e-3f);
  }
}

TEST_CASE("the picture of any size is finite and positive", "[isa][field]") {
  Run run;
  for (int i = 0; i < 3; ++i) run.take(i, 5);
  for (int step : {1, 2, 3, 7}) {
    const FieldPicture& view = run.look(step);
    CHECK(view.radiance.cols() == (run.scene.cols + step - 1) / step);
    for (float v : view.radiance.samples()) CHECK((std::isfinite(v) && v > 0));
    for (float v : view.depth.samples()) CHECK((std::isfinite(v) && v >= 1));
  }
}

TEST_CASE("steps lower the loss", "[isa][field]") {
  FieldOptions options = FitStream::small_options();
  Run run(options);
  for (int i = 0; i < 4; ++i) run.take(i, 0, true);
  double first = 0, last = 0;
  for (int s = 0; s < 300; ++s) {
    const StepReport report = run.fit.step();
    REQUIRE(report.verdict == StepVerdict::Taken);
    REQUIRE(std::isfinite(report.total));
    if (s < 20) first += report.total;
    if (s >= 280) last += report.total;
  }
  INFO("loss " << first / 20 << " -> " << last / 20);
  CHECK(last < 0.9 * first);
}

TEST_CASE("what a neighbour saw reaches the frame that was blind", "[isa][field]") {
  // the long exposure clips the square, and this state forgets at once: only the window knows
  const auto error_after = [](int steps) {
    Run run;
    for (int i = 0; i < 3; ++i) run.take(i, steps, true);
    return log_error(run.scene, run.look(), 2, true);
  };
  const double blind = error_after(0), filled = error_after(200);
  INFO("log error on the clipped square " << blind << " -> " << filled);
  CHECK(blind > 1);
  CHECK(filled < 0.5 * blind);
}

TEST_CASE("codes are compared at the exposure of their frame, and a state that is too bright is corrected",
          "[isa][field]") {
  const auto error_after = [](int steps) {
    Run run;
    for (int i = 0; i < 3; ++i) {
      FieldObservation seen = run.scene.frame(i);
      for (float& v : run.scene.radiance.samples()) v *= 1.6f;
      for (float& v : run.scene.variance.samples()) v *= 100;
      REQUIRE(run.fit.observe(seen, run.scene.response).ok());
      run.last_time_s = seen.time_s;
      for (int s = 0; s < steps; ++s) run.fit.step();
    }
    return log_error(run.scene, run.look(), 2, false);
  };
  const double bright = error_after(0), corrected = error_after(200);
  INFO("log error " << bright << " -> " << corrected);
  CHECK(bright > 0.4);
  CHECK(corrected < 0.5 * bright);
}

TEST_CASE("one and two threads give the same bytes", "[isa][field]") {
  const auto bytes = [](int threads) {
    Run run(FitStream::small_options(), threads);
    for (int i = 0; i < 4; ++i) run.take(i, 7);
    return run.look().radiance.clone();
  };
  const Image<float> one = bytes(1), two = bytes(2), three = bytes(3);
  CHECK(std::memcmp(one.plane(0), two.plane(0), one.size() * sizeof(float)) == 0);
  CHECK(std::memcmp(one.plane(0), three.plane(0), one.size() * sizeof(float)) == 0);
}

TEST_CASE("nothing moves, so the dynamic branch is not evaluated", "[isa][field]") {
  Run run;
  run.scene.speed_px = 0;
  for (int i = 0; i < 3; ++i) run.take(i, 4);
  CHECK_FALSE(run.fit.field().has_dynamic);
  CHECK(run.fit.counts().without_dynamic == 12);
}

TEST_CASE("between two frames the content is between its places", "[isa][field]") {
  Run run;
  run.scene.speed_px = 4;
  for (int i = 0; i < 3; ++i) run.take(i, 0);
  const double half = run.last_time_s - 0.5 / 30;
  FieldPicture between;
  run.renderer.render(run.fit.field(), FitStream::view(run.fit, {}, half, 1), run.pool, between);
  // at frame 1 the square's front edge is at 20, at frame 2 at 24
  const auto is_bright = [&](int x) { return between.radiance.at(1, 14, x) > 1; };
  CHECK(is_bright(19));
  CHECK_FALSE(is_bright(23));
}

TEST_CASE("the anchor follows a camera that leaves it, and the field stays the state's picture",
          "[isa][field]") {
  Run run;
  run.scene.speed_px = 0;
  RigidTransform pose;
  for (int i = 0; i < 12; ++i) {
    FieldObservation seen = run.scene.frame(i);
    pose.t.x() = 0.12 * i;
    seen.T_world_camera = pose;
    REQUIRE(run.fit.observe(seen, run.scene.response).ok());
    run.last_time_s = seen.time_s;
  }
  CHECK(run.fit.counts().anchors_moved >= 1);
  CHECK(run.fit.field().window.has_parallax());
  FieldPicture view;
  run.renderer.render(run.fit.field(), FitStream::view(run.fit, pose, run.last_time_s, 1), run.pool, view);
  for (std::size_t p = 0; p < view.radiance.size(); ++p)
    REQUIRE(view.radiance.samples()[p] == Approx(run.scene.radiance.samples()[p]).epsilon(0.02));
}

TEST_CASE("a moved view shows behind something near what another frame saw there, or what is beside it",
          "[isa][field]") {
  // it stands: nobody ever saw what is behind it
  CHECK(hidden_place(0, 0.1f, 0, 12) == Approx(0.4).epsilon(0.1));
  // it moved by 6 px: the frame before saw the bright wall there; beside it the wall is dark
  CHECK(hidden_place(6, 0.1f, 0, 36) == Approx(0.4).epsilon(0.1));
  // not at rest, or nearer than what is beside it: it is no background
  CHECK(hidden_place(6, 0.1f, 3, 36) == Approx(0.1).epsilon(0.1));
  CHECK(hidden_place(6, 0.3f, 0, 36) == Approx(0.1).epsilon(0.1));
}

TEST_CASE("a field that starts anew knows only the frames that follow", "[isa][field]") {
  Run run;
  for (int i = 0; i < 4; ++i) run.take(i, 3);
  run.fit.restart();
  run.take(30, 0);
  CHECK(run.fit.field().window.size() == 1);
  const FieldPicture& view = run.look();
  for (std::size_t p = 0; p < view.radiance.size(); ++p)
    REQUIRE(view.radiance.samples()[p] == Approx(run.scene.radiance.samples()[p]).epsilon(0.02));
  run.take(31, 3);
  CHECK(run.fit.field().window.size() == 2);
}

TEST_CASE("a frame that does not fit is refused and changes nothing", "[isa][field]") {
  Run run;
  run.take(0, 2);
  FieldObservation seen = run.scene.frame(1);
  SECTION("exposure") {
    seen.exposure = GENERATE(0.f, -1.f, std::numeric_limits<float>::quiet_NaN());
    const auto result = run.fit.observe(seen, run.scene.response);
    REQUIRE_FALSE(result.ok());
    CHECK(result.error().code == ErrorCode::BadExposure);
  }
  SECTION("size") {
    Image<float> other(3, 8, 8);
    seen.codes = &other;
    const auto result = run.fit.observe(seen, run.scene.response);
    REQUIRE_FALSE(result.ok());
    CHECK(result.error().code == ErrorCode::Invalid);
  }
  CHECK(run.fit.field().window.size() == 1);
}
