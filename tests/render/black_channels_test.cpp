#include "render/black_channels.h"

#include "online/state/radiance_state.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

constexpr int kRows = 48, kCols = 64;
constexpr float kDarkest = 0.02f;  // of green; red and blue show much less

// A bluish grey scene of which a part is too dark for green: it stands at the green of a dark code.
struct Scene {
  RadianceEstimate seen{Image<float>(3, kRows, kCols), Image<float>(3, kRows, kCols)};
  Image<float>&radiance = seen.radiance, &variance = seen.variance;
  WorkerPool pool{2};
  const BlackChannels black{{0.001f, kDarkest, 0.001f}, 10, 1e-4f};
  const int y = 40, x = 50;  // a pixel of that part

  Scene() {
    for (int row = 0; row < kRows; ++row)
      for (int col = 0; col < kCols; ++col) {
        const float level = row < kRows / 2 ? 0.2f : 0.004f;
        put(row, col, {level, level, 2 * level}, 0.01f);
        if (row < kRows / 2) continue;
        radiance.at(1, row, col) = kDarkest / 2;
        variance.at(1, row, col) = 4 * kDarkest * kDarkest;
      }
  }
  void put(int row, int col, std::array<float, 3> light, float relative) {
    for (int c = 0; c < 3; ++c) {
      const float value = light[static_cast<std::size_t>(c)];
      radiance.at(c, row, col) = value;
      variance.at(c, row, col) = relative * relative * value * value;
    }
  }
  std::array<float, 3> coloured() {
    Image<float> result;
    colour_black_channels(black, seen, result, pool);
    return {result.at(0, y, x), result.at(1, y, x), result.at(2, y, x)};
  }
};

}  // namespace

TEST_CASE("a channel that is black gets the usual colour at the level of the others") {
  Scene scene;
  const auto [red, green, blue] = scene.coloured();
  CHECK(red == 0.004f);
  CHECK(blue == 0.008f);
  CHECK(green < 0.0055f);  // .004 is what the others say, .01 what its code does
  CHECK(green > 0.0035f);
}

TEST_CASE("a channel that is black never gets brighter, and one that shows light stays as it is") {
  Scene scene;
  scene.put(scene.y, scene.x, {0.4f, kDarkest / 2, 0.8f}, 0.01f);
  scene.variance.at(1, scene.y, scene.x) = 4 * kDarkest * kDarkest;
  CHECK(scene.coloured()[1] == kDarkest / 2);
  scene.put(scene.y, scene.x, {0.004f, kDarkest * 1.01f, 0.008f}, 0.01f);
  scene.variance.at(1, scene.y, scene.x) = 4 * kDarkest * kDarkest;
  CHECK(scene.coloured()[1] == kDarkest * 1.01f);
  scene.put(scene.y, scene.x, {0.004f, kDarkest / 2, 0.008f}, 0.01f);  // dark, and sure of it
  CHECK(scene.coloured()[1] == kDarkest / 2);
  scene.variance.at(1, scene.y, scene.x) = kUnseenVariance;
  CHECK(scene.coloured()[1] == kDarkest / 2);
}

TEST_CASE("where all channels are black they are as dark as the one that shows most") {
  Scene scene;
  scene.put(scene.y, scene.x, {0.0005f, kDarkest / 2, 0.001f}, 3);
  const auto [red, green, blue] = scene.coloured();
  CHECK(red == Approx(0.0005f).epsilon(0.1));
  CHECK(green < kDarkest / 8);
  CHECK(blue == Approx(0.001f).epsilon(0.02));
}

TEST_CASE("where no pixel tells what colours are usual a channel that is black stays as it is") {
  Scene scene;
  scene.variance.fill(1);
  CHECK(scene.coloured()[1] == kDarkest / 2);
}
