#include "render/display_light.h"

#include <algorithm>

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("PQ signals are those of SMPTE ST 2084, and come back as the luminance they stand for") {
  CHECK(pq_signal(10000) == Approx(1));
  CHECK(pq_signal(1000) == Approx(0.7518).margin(1e-4));  // Report ITU-R BT.2408, table 1
  CHECK(pq_signal(203) == Approx(0.5807).margin(1e-4));
  CHECK(pq_signal(100) == Approx(0.5081).margin(1e-4));
  CHECK(pq_signal(0) == Approx(0).margin(1e-6));
  for (const double nits : {0.005, 0.1, 1.0, 26.0, 203.0, 999.0, 4000.0, 10000.0})
    CHECK(pq_nits(pq_signal(nits)) == Approx(nits).epsilon(1e-9));
}

TEST_CASE("light that the display can show is shown as it is, and clipped above its peak") {
  const HighlightShoulder shoulder(812, 1000);
  for (const double nits : {0.0, 0.01, 203.0, 812.0, 1000.0}) CHECK(shoulder.shown(nits) == nits);
  CHECK(shoulder.shown(1500) == 1000);
}

TEST_CASE(
    "the shoulder takes brighter light into the display's range: exact below its knee, in order above it") {
  for (const double source : {1300.0, 4000.0, 10000.0, 60000.0}) {
    const HighlightShoulder shoulder(source, 1000);
    INFO(source << " knee " << shoulder.knee_nits());
    CHECK(shoulder.knee_nits() > 203);
    CHECK(shoulder.knee_nits() < 1000);
    CHECK(shoulder.shown(shoulder.knee_nits()) == shoulder.knee_nits());
    CHECK(shoulder.shown(shoulder.knee_nits() * 1.0001) / shoulder.knee_nits() ==
          Approx(1.0001).epsilon(1e-5));
    double before = 0;
    for (double nits = 1; nits < std::min(source, 10000.0); nits *= 1.05) {
      const double shown = shoulder.shown(nits);
      CHECK(shown > before);
      CHECK(shown <= std::min(nits * (1 + 1e-12), 1000.0));
      before = shown;
    }
    CHECK(shoulder.shown(source) == Approx(1000).epsilon(1e-6));
    CHECK(shoulder.shown(1e9) == Approx(1000).epsilon(1e-6));
  }
}

TEST_CASE("grey keeps its luminance, a colour its hue, and the brightest channel is what is counted") {
  Image<float> radiance(3, 1, 3), light(3, 1, 16);
  const float pixels[3][3] = {{0.5f, 0.5f, 0.5f}, {8, 8, 8}, {4, 0, 0}};
  for (int x = 0; x < 3; ++x)
    for (int c = 0; c < 3; ++c) radiance.at(c, 0, x) = pixels[x][c];
  const DisplayLight display(203, 1000, 16);
  const PictureLight counted = display.show(radiance, light);
  for (int c = 0; c < 3; ++c) CHECK(light.at(c, 0, 0) == Approx(101.5).epsilon(1e-4));
  const auto shown = static_cast<float>(display.shoulder().shown(8 * 203));
  for (int c = 0; c < 3; ++c) CHECK(light.at(c, 0, 1) == Approx(shown).epsilon(1e-4));
  CHECK(light.at(1, 0, 2) / light.at(0, 0, 2) == Approx(0.0691 / 0.6274).epsilon(1e-4));
  CHECK(light.at(2, 0, 2) / light.at(0, 0, 2) == Approx(0.0164 / 0.6274).epsilon(1e-4));
  CHECK(counted.largest_nits == Approx(shown).epsilon(1e-4));
  CHECK(counted.mean_nits ==
        Approx((101.5 + static_cast<double>(shown) + static_cast<double>(light.at(0, 0, 2))) / 3)
            .epsilon(1e-4));
}

TEST_CASE("light beyond what a float holds in cd/m2 is as bright as the display, and its hue stays") {
  Image<float> radiance(3, 1, 3), light(3, 1, 16);
  const float pixels[3][3] = {{1e37f, 1e37f, 1e37f}, {3.4e38f, 3.4e38f, 3.4e38f}, {3.4e38f, 0, 0}};
  for (int x = 0; x < 3; ++x)
    for (int c = 0; c < 3; ++c) radiance.at(c, 0, x) = pixels[x][c];
  const PictureLight counted = DisplayLight(203, 1000, 16).show(radiance, light);
  for (int x = 0; x < 2; ++x)
    for (int c = 0; c < 3; ++c) CHECK(light.at(c, 0, x) == Approx(1000).epsilon(1e-3));
  CHECK(light.at(0, 0, 2) == Approx(1000).epsilon(1e-3));
  CHECK(light.at(1, 0, 2) / light.at(0, 0, 2) == Approx(0.0691 / 0.6274).epsilon(1e-4));
  CHECK(counted.largest_nits == Approx(1000).epsilon(1e-3));
}
