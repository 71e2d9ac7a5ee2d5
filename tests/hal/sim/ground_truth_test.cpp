// Ground truth checked by other means than those that made it: pinhole arithmetic in double precision, the
// formulas of response and noise, counts of saturated pixels.
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "hal/sim/scene_truth.h"
#include "hal/sim/simulated_sensor.h"
#include "tests/contracts/expect.h"

using namespace hdrcam;

namespace {

constexpr int kRows = 72, kCols = 96;

// A sensor, what it recorded in one shot, and the truth at the middle of that shot.
struct Filmed {
  Filmed(const std::string& spec, PixelLayout layout, int bits, Shot with)
      : shot(with), sensor(value_of(simulation_of(spec)), layout, bits, pool) {
    sensor.expose(shot, codes);
    TruthRenderer(*sensor.scene(), sensor.lens(), kRows, kCols, pool, sensor.vignetting())
        .render(shot.begin_s + shot.exposure_s / 2, shot.begin_s + 1.0 / 30, truth);
  }
  // Relative exposure of a sample by the words of gt.json, 1 saturates.
  double exposure(int channel, int y, int x) const {
    return static_cast<double>(truth.radiance.at(channel, y, x)) * shot.exposure_s * shot.gain * 167.5;
  }

  WorkerPool pool{2};
  Shot shot;
  SimulatedSensor sensor;
  Image<std::uint16_t> codes;
  SceneTruth truth;
};

std::string sized(const std::string& spec) {
  return spec + (spec.find('?') == std::string::npos ? "?" : "&") + "size=96x72";
}

// A pinhole camera with radial distortion, in double precision and by bisection: nothing of hal/sim/lens.h.
struct PlainCamera {
  Intrinsics lens;
  double k1 = 0, k2 = 0;

  struct Point {
    double x, y;
  };
  double bent(double r) const { return r * (1 + k1 * r * r + k2 * r * r * r * r); }
  Point ray(double px, double py) const {
    const double x = (px - lens.cx_px) / lens.fx_px, y = (py - lens.cy_px) / lens.fy_px;
    const double seen = std::hypot(x, y);
    double low = 0, high = 2 * seen;
    for (int i = 0; i < 60; ++i) (bent((low + high) / 2) < seen ? low : high) = (low + high) / 2;
    const double factor = seen > 0 ? low / seen : 1;
    return {x * factor, y * factor};
  }
  Point pixel(double x, double y) const {
    const double r = std::hypot(x, y), factor = r > 0 ? bent(r) / r : 1;
    return {x * factor * lens.fx_px + lens.cx_px, y * factor * lens.fy_px + lens.cy_px};
  }
};

// R p + t and its inverse, of a pose as gt.json has it.
std::array<double, 3> to_world(const Pose& pose, std::array<double, 3> p) {
  const Mat3& R = pose.rotation;
  const auto row = [&](float a, float b, float c, float t) {
    return static_cast<double>(a) * p[0] + static_cast<double>(b) * p[1] + static_cast<double>(c) * p[2] +
           static_cast<double>(t);
  };
  return {row(R.c0.x, R.c1.x, R.c2.x, pose.position.x), row(R.c0.y, R.c1.y, R.c2.y, pose.position.y),
          row(R.c0.z, R.c1.z, R.c2.z, pose.position.z)};
}
std::array<double, 3> to_camera(const Pose& pose, std::array<double, 3> p) {
  const Mat3& R = pose.rotation;
  const double x = p[0] - static_cast<double>(pose.position.x),
               y = p[1] - static_cast<double>(pose.position.y),
               z = p[2] - static_cast<double>(pose.position.z);
  const auto along = [&](Vec3 c) {
    return static_cast<double>(c.x) * x + static_cast<double>(c.y) * y + static_cast<double>(c.z) * z;
  };
  return {along(R.c0), along(R.c1), along(R.c2)};
}

}  // namespace

TEST_CASE("depth and poses reproject to the given flow wherever nothing moves, in every scene") {
  for (const CatalogScene& entry : scene_catalog()) {
    WorkerPool pool(2);
    const Simulation s = value_of(simulation_of(sized(entry.name)));
    const SimulatedSensor sensor(s, PixelLayout::Rgb, 8, pool);
    TruthRenderer renderer(*sensor.scene(), sensor.lens(), kRows, kCols, pool);
    SceneTruth now, next;
    renderer.render(0.9, 1.0, now);
    renderer.render(1.0, 1.1, next);
    PlainCamera camera{sensor.lens().intrinsics};
    if (s.plan.on(Effect::Distortion))
      camera.k1 = static_cast<double>(s.distortion.k1), camera.k2 = static_cast<double>(s.distortion.k2);
    int checked = 0;
    double worst_px = 0;
    for (int y = 0; y < kRows; ++y)
      for (int x = 0; x < kCols; ++x) {
        if (sensor.scene()->objects[now.ids.at(0, y, x)].moves()) continue;
        const auto ray = camera.ray(x + 0.5, y + 0.5);
        const double depth_m = static_cast<double>(now.depth.at(0, y, x));
        const auto p = to_camera(next.T_world_camera,
                                 to_world(now.T_world_camera, {ray.x * depth_m, ray.y * depth_m, depth_m}));
        const auto seen = camera.pixel(p[0] / p[2], p[1] / p[2]);
        worst_px = std::max({worst_px, std::abs(seen.x - x - 0.5 - static_cast<double>(now.flow.at(0, y, x))),
                             std::abs(seen.y - y - 0.5 - static_cast<double>(now.flow.at(1, y, x)))});
        ++checked;
      }
    INFO(entry.name);
    CHECK(checked > kRows * kCols / 2);
    CHECK(worst_px < 5e-3);
  }
}

TEST_CASE("the depth of the next frame is that of the point which the flow leads to") {
  WorkerPool pool(2);
  const SimulatedSensor sensor(value_of(simulation_of(sized("walk"))), PixelLayout::Rgb, 8, pool);
  TruthRenderer renderer(*sensor.scene(), sensor.lens(), kRows, kCols, pool);
  SceneTruth now, next;
  renderer.render(0.9, 0.95, now);
  renderer.render(0.95, 1.0, next);
  const PlainCamera camera{sensor.lens().intrinsics};
  int checked = 0, agree = 0;
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kCols; ++x) {
      const int id = now.ids.at(0, y, x);
      if (sensor.scene()->objects[static_cast<std::size_t>(id)].moves() || now.flow.at(2, y, x) > 0.5f)
        continue;
      const auto ray = camera.ray(x + 0.5, y + 0.5);
      const double depth_m = static_cast<double>(now.depth.at(0, y, x));
      const auto p = to_camera(next.T_world_camera,
                               to_world(now.T_world_camera, {ray.x * depth_m, ray.y * depth_m, depth_m}));
      const int to_x = static_cast<int>(std::floor(static_cast<float>(x) + 0.5f + now.flow.at(0, y, x)));
      const int to_y = static_cast<int>(std::floor(static_cast<float>(y) + 0.5f + now.flow.at(1, y, x)));
      if (to_x < 0 || to_y < 0 || to_x >= kCols || to_y >= kRows || next.ids.at(0, to_y, to_x) != id)
        continue;
      ++checked;
      agree +=
          std::abs(p[2] / static_cast<double>(next.depth.at(0, to_y, to_x)) - 1) < 0.06;  // half a pixel off
    }
  CHECK(checked > kRows * kCols / 2);
  CHECK(agree > 0.97 * checked);
}

TEST_CASE("radiance through the response gives the recorded codes, vignetting and black level included") {
  const Filmed scene(sized("walk?without=noise,motion-blur&black=0.05"), PixelLayout::Rgb, 8,
                     {3, 0.5, 0.004, 1});
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < kRows; ++y)
      for (int x = 0; x < kCols; ++x) {
        const double curve =
            ResponseCurve::exact(CurveShape::Film, c, std::min(1.0, scene.exposure(c, y, x)));
        REQUIRE(scene.codes.at(c, y, x) == Approx(255 * (0.05 + 0.95 * curve)).margin(0.55));
      }
}

TEST_CASE("what noise adds to the radiance has the variance that the formula says") {
  const Filmed scene(sized("still?black=0.05&read-noise=5&response=linear"), PixelLayout::Rgb, 14,
                     {3, 0.5, 0.002, 1});
  double sum = 0, sum2 = 0;
  int count = 0;
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < kRows; ++y)
      for (int x = 0; x < kCols; ++x) {
        const double expected_e = 6000 * scene.exposure(c, y, x);
        if (expected_e > 5500) continue;
        const double code = scene.codes.at(c, y, x), electrons = 6000 * (code / 16383 - 0.05) / 0.95;
        const double z =
            (electrons - expected_e) / std::sqrt(expected_e + 25 + 0.011);  // shot, read, rounding
        sum += z, sum2 += z * z, ++count;
      }
  REQUIRE(count > 10'000);
  CHECK(sum / count == Approx(0).margin(5 / std::sqrt(count)));
  CHECK(sum2 / count == Approx(1).margin(5 * std::sqrt(2.0 / count)));
}

TEST_CASE("a saturated pixel is saturated, noise or not, in 8 bits and in 12") {
  for (const char* spec : {"lamps?without=motion-blur,flare", "lamps?without=motion-blur,flare,noise"})
    for (const int bits : {8, 12}) {
      const auto layout = bits == 8 ? PixelLayout::Rgb : PixelLayout::BayerRggb;
      const Filmed scene(sized(spec), layout, bits, {3, 0.5, 0.008, 1});
      const int most = (1 << bits) - 1;
      int saturated = 0, below = 0;
      for (int y = 0; y < kRows; ++y)
        for (int x = 0; x < kCols; ++x) {
          const int channel = bits == 8 ? 1 : Mosaic(layout).channel(y, x);
          const int code = scene.codes.at(bits == 8 ? 1 : 0, y, x);
          const double exposure = scene.exposure(channel, y, x);
          INFO(spec << ", " << bits << " bits, pixel " << x << ", " << y << ", exposure " << exposure);
          if (exposure > 1.1) REQUIRE(code == most);
          if (exposure < 0.9) REQUIRE(code < most);
          saturated += exposure > 1.1, below += exposure < 0.9;
        }
      CHECK(saturated > 100);
      CHECK(below > 100);
    }
}

TEST_CASE("a full pixel is saturated where few electrons fill it, and where reading is as noisy as can be") {
  for (const char* spec : {"lamps?without=motion-blur,flare&full-well=100",
                           "lamps?without=motion-blur,flare&full-well=1500&read-noise=100"}) {
    const Filmed scene(sized(spec), PixelLayout::Rgb, 8, {3, 0.5, 0.016, 1});
    int full = 0, saturated = 0;
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < kRows; ++y)
        for (int x = 0; x < kCols; ++x)
          if (scene.exposure(c, y, x) > 3) ++full, saturated += scene.codes.at(c, y, x) == 255;
    INFO(spec);
    CHECK(full > 1000);
    CHECK(saturated == full);
  }
}

TEST_CASE("under a rolling shutter each row flickers with its own instant, all within a frame") {
  const double readout_s = GENERATE(0.012, 0.005);
  const std::string fps = readout_s < 0.012 ? "200" : "30";
  const std::string plain = sized("still?without=noise&response=linear&with=rolling-shutter&fps=" + fps);
  const Shot shot{3, 0.5, 0.002, 1};
  const Filmed steady(plain, PixelLayout::Rgb, 16, shot);
  const Filmed flickering(plain + "&with=mains-flicker", PixelLayout::Rgb, 16, shot);
  double least = 2, most = 0;
  for (int y = 0; y < kRows; ++y) {
    const double opens_s = 0.5 + readout_s * y / kRows;
    double expected = 0;  // of a lamp that glows as 1 + 0.3 cos(2 pi 100 t)
    for (int i = 0; i < 1000; ++i)
      expected += 1 + 0.3 * std::cos(2 * std::numbers::pi * 100 * (opens_s + 0.002 * (i + 0.5) / 1000));
    expected /= 1000;
    for (int x = 0; x < kCols; ++x) {
      const double before = steady.codes.at(1, y, x), after = flickering.codes.at(1, y, x);
      if (before < 1000 || before * 1.3 > 65'000) continue;
      REQUIRE(after / before == Approx(expected).epsilon(2e-3));
    }
    least = std::min(least, expected), most = std::max(most, expected);
  }
  CHECK(most / least > 1.5);
}
