// Scenes and their ground truth: what one frame says of a point must be what the next frame shows.
#include <algorithm>
#include <cmath>
#include <string>

#include "hal/sim/scene_truth.h"
#include "hal/sim/simulated_sensor.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr int kRows = 72, kCols = 96;

Simulation small(const std::string& spec) {
  auto simulation =
      simulation_of(spec + (spec.find('?') == std::string::npos ? "?size=96x72" : "&size=96x72"));
  REQUIRE(simulation.ok());
  return *simulation;
}

struct Stage {
  explicit Stage(const Simulation& s)
      : scene(make_scene(s.scene, 64, pool)), lens{centred_intrinsics(s.width, s.height, 1), std::nullopt} {
    if (s.plan.on(Effect::Distortion)) lens.distortion.emplace(s.distortion);
  }
  WorkerPool pool{2};
  Scene scene;
  Lens lens;
};

Vec3 world_point(const Stage& stage, const SceneTruth& truth, int y, int x) {
  const Vec2 ray = stage.lens.ray_of(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
  const float depth = truth.depth.at(0, y, x);
  return truth.T_world_camera.rotation * Vec3{ray.x * depth, ray.y * depth, depth} +
         truth.T_world_camera.position;
}

}  // namespace

TEST_CASE("a point warped by the true flow lands on the same surface point, of the same radiance") {
  for (const CatalogScene& entry : scene_catalog()) {
    Stage stage(small(entry.name));
    TruthRenderer renderer(stage.scene, stage.lens, kRows, kCols, stage.pool);
    SceneTruth truth;
    View now, next;
    for (const double time_s : {0.4, 3.1}) {
      const double next_s = time_s + 1.0 / 30;
      renderer.render(time_s, next_s, truth);
      now.pose_at(stage.scene, time_s);
      next.pose_at(stage.scene, next_s);
      int followed = 0;
      double difference = 0;
      for (int y = 0; y < kRows; ++y)
        for (int x = 0; x < kCols; ++x) {
          if (truth.flow.at(2, y, x) > 0.5f) continue;
          const float px = static_cast<float>(x) + 0.5f, py = static_cast<float>(y) + 0.5f;
          const float to_x = px + truth.flow.at(0, y, x), to_y = py + truth.flow.at(1, y, x);
          const auto hit_near = [&](float dx, float dy) {
            return next.cast(stage.lens.ray_of(to_x + dx, to_y + dy));
          };
          const Hit from = now.cast(stage.lens.ray_of(px, py)), to = hit_near(0, 0);
          INFO(entry.name << " at " << time_s << " s, pixel " << x << ", " << y);
          REQUIRE(from.object == truth.ids.at(0, y, x));
          const Hit right = hit_near(0.02f, 0), below = hit_near(0, 0.02f);
          const bool outline =
              to.object != from.object || right.object != to.object || below.object != to.object;
          if (outline) continue;  // a rounding error decides which surface is met
          ++followed;
          const float explained_m =
              length(right.point - to.point) + length(below.point - to.point) + 1e-4f;  // 0.02 px
          REQUIRE(length(to.point - from.point) < explained_m);
          if (stage.scene.objects[static_cast<std::size_t>(from.object)].surface != Surface::Radiant)
            continue;
          const float before = luminance(now.radiance(from, 0.02f)),
                      after = luminance(next.radiance(to, 0.02f));
          REQUIRE(std::abs(after - before) <
                  0.4f * before + 1e-4f);  // a nearer or less slanted texture is filtered less
          difference += static_cast<double>(std::abs(after - before) / before);
        }
      CHECK(followed > kRows * kCols * 3 / 4);
      CHECK(difference / followed < 0.005);
    }
  }
}

TEST_CASE("depth and pose place a resting point where the next camera sees it along the flow") {
  Stage stage(small("walk?objects=0&lamps=0"));
  TruthRenderer renderer(stage.scene, stage.lens, kRows, kCols, stage.pool);
  SceneTruth truth;
  renderer.render(1.0, 1.2, truth);
  const Pose later = stage.scene.camera.at(1.2);
  for (int y = 0; y < kRows; y += 3)
    for (int x = 0; x < kCols; x += 3) {
      const Vec3 p = transposed_times(later.rotation, world_point(stage, truth, y, x) - later.position);
      const Vec2 pixel = stage.lens.pixel_of({p.x / p.z, p.y / p.z});
      CHECK(pixel.x - static_cast<float>(x) - 0.5f == Approx(truth.flow.at(0, y, x)).margin(2e-3));
      CHECK(pixel.y - static_cast<float>(y) - 0.5f == Approx(truth.flow.at(1, y, x)).margin(2e-3));
    }
}

TEST_CASE("flow marks what is hidden in the next frame, and nothing where nothing moves") {
  Stage fast(small("fast")), still(small("still"));
  SceneTruth truth;
  TruthRenderer(fast.scene, fast.lens, kRows, kCols, fast.pool).render(0.5, 0.6, truth);
  int hidden = 0;
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kCols; ++x) hidden += truth.flow.at(2, y, x) > 0.5f;
  CHECK(hidden > 20);
  TruthRenderer(still.scene, still.lens, kRows, kCols, still.pool).render(0.5, 0.6, truth);
  for (const float value : truth.flow.samples()) REQUIRE(std::abs(value) < 1e-3f);
}

TEST_CASE("every scene spans more than twelve stops") {
  for (const CatalogScene& entry : scene_catalog()) {
    Stage stage(small(entry.name));
    TruthRenderer renderer(stage.scene, stage.lens, kRows, kCols, stage.pool);
    SceneTruth truth;
    float darkest = 1e9f, brightest = 0;
    for (int i = 0; i < 6; ++i) {
      renderer.render(0.8 * i, 0.8 * i + 0.03, truth);
      for (int y = 0; y < kRows; ++y)
        for (int x = 0; x < kCols; ++x) {
          const float value =
              luminance({truth.radiance.at(0, y, x), truth.radiance.at(1, y, x), truth.radiance.at(2, y, x)});
          REQUIRE(std::isfinite(value));
          REQUIRE(value > 0);
          darkest = std::min(darkest, value), brightest = std::max(brightest, value);
        }
    }
    INFO(entry.name << ": " << darkest << " to " << brightest);
    CHECK(std::log2(brightest / darkest) > 12);
  }
}

TEST_CASE("a scene is as good after an hour: camera and objects stay where they belong") {
  for (const CatalogScene& entry : scene_catalog()) {
    Stage stage(small(entry.name));
    View view;
    for (const double time_s : {0.0, 1800.0, 3599.0}) {
      view.pose_at(stage.scene, time_s);
      CHECK(length(view.camera().position) < 0.6f * entry.distance_m);
      const Hit hit = view.cast({0, 0});
      CHECK(std::isfinite(hit.depth_m));
      CHECK(hit.depth_m > 0.05f * entry.distance_m);
    }
  }
}

TEST_CASE("a lit surface is as bright from afar as from nearby") {
  WorkerPool pool(1);
  Scene scene = make_scene(small("still").scene, 32, pool);
  const auto lit = std::ranges::find(scene.objects, Surface::Lit, &SceneObject::surface);
  REQUIRE(lit != scene.objects.end());
  const auto index = static_cast<std::uint8_t>(lit - scene.objects.begin());
  lit->shape = Shape::Panel, lit->half_size_m = {1, 1, 1}, lit->centre_m = {0, 0, 4}, lit->motion = {};
  lit->tiles_per_m = 1;  // whole tiles, so that their mean is that of the panel
  View view;
  for (const int pattern : {0, 1, 2, 3}) {
    lit->texture = lit->texture / 6 * 6 + pattern;
    view.pose_at(scene, 0);
    constexpr int kSide = 256;  // rays
    double nearby = 0, afar = 0;
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const auto along = [](int k) { return ((static_cast<float>(k) + 0.5f) / kSide - 0.5f) / 2; };
        const Hit hit = view.cast({along(x), along(y)}, {&index, 1});
        REQUIRE(hit.object == index);
        nearby += static_cast<double>(luminance(view.radiance(hit, 1e-4f)));
        afar += static_cast<double>(luminance(view.radiance(hit, 0.02f)));
      }
    INFO("pattern " << pattern);
    CHECK(std::abs(std::log2(afar / nearby)) < 0.01);
  }
}

TEST_CASE("the rays that may meet an object hold every point of it") {
  Stage stage(small("fast?objects=24&lamps=6&pulse=0.3"));
  View view;
  int seen = 0;
  for (const double time_s : {0.0, 0.7, 2.9}) {
    view.pose_at(stage.scene, time_s);
    for (std::size_t i = 2; i < stage.scene.objects.size(); ++i) {  // dome and ground have no bounds
      const SceneObject& object = stage.scene.objects[i];
      for (const float x : {-1.f, 0.f, 1.f})
        for (const float y : {-1.f, 0.f, 1.f})
          for (const float z : {-1.f, 0.f, 1.f}) {
            Vec3 point = object.half_size_m * Vec3{x, y, object.shape == Shape::Panel ? 0 : z};
            if (object.shape == Shape::Ball) point = normalized(Vec3{x, y, z}) * object.half_size_m.x;
            const Vec3 ray = view.project(static_cast<int>(i), point);
            if (ray.z <= 0) continue;
            ++seen;
            RayBox box = view.bounds(static_cast<int>(i));
            const float rounding = 1e-5f;
            box.x0 -= rounding, box.x1 += rounding, box.y0 -= rounding, box.y1 += rounding;
            REQUIRE(box.holds({ray.x, ray.y}));
          }
    }
  }
  CHECK(seen > 1000);
}

TEST_CASE("a ray that is told what it can meet meets the same as one that tries everything") {
  Stage stage(small("fast?objects=24&lamps=6"));
  View view;
  view.pose_at(stage.scene, 0.7);
  std::vector<std::uint8_t> near;
  int objects_met = 0;
  for (float y = -0.4f; y < 0.4f; y += 0.02f)
    for (float x = -0.5f; x < 0.5f; x += 0.02f) {
      near.clear();
      for (int i = Scene::kDome + 1; i < static_cast<int>(stage.scene.objects.size()); ++i)
        if (view.bounds(i).holds({x, y})) near.push_back(static_cast<std::uint8_t>(i));
      const Hit told = view.cast({x, y}, near), tried = view.cast({x, y});
      REQUIRE(told.object == tried.object);
      REQUIRE(told.depth_m == tried.depth_m);
      objects_met += told.object > 1;
    }
  CHECK(objects_met > 100);
}

TEST_CASE("seeds make other scenes, settings make what they say") {
  WorkerPool pool(1);
  const Scene first = make_scene(small("walk?seed=1").scene, 32, pool),
              other = make_scene(small("walk?seed=2").scene, 32, pool);
  REQUIRE(first.objects.size() == other.objects.size());
  CHECK(length(first.objects.back().centre_m - other.objects.back().centre_m) > 1e-3f);
  const Scene crowded = make_scene(small("walk?objects=20&lamps=5").scene, 32, pool);
  CHECK(crowded.objects.size() == 2 + 20 + 5);  // dome and ground
  const Scene frozen = make_scene(small("walk?speed=0&camera=still").scene, 32, pool);
  CHECK_FALSE(frozen.moves());
  CHECK(first.moves());
}
