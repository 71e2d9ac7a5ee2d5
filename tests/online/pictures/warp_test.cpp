#include "online/pictures/warp.h"

#include <cmath>
#include <limits>

#include "tests/support/uniform_flow.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

Image<float> texture(int rows, int cols) {
  Image<float> image(3, rows, cols);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < cols; ++x)
        image.at(c, y, x) = 2 + static_cast<float>(std::sin(0.31 * x + c) * std::cos(0.23 * y));
  return image;
}

Image<float> uniform_vectors(int rows, int cols, float dx, float dy) {
  return test::uniform_flow(rows, cols, dx, dy).vectors;
}

}  // namespace

TEST_CASE("a picture that does not move is copied bit for bit") {
  WorkerPool pool(2);
  const auto image = texture(21, 34);
  Image<float> out;
  for (const float tiny : {0.f, 0.01f, -0.015f}) {  // below half of 1/32 pixel
    warp_radiance(image, uniform_vectors(21, 34, tiny, -tiny), out, pool);
    REQUIRE(std::equal(image.samples().begin(), image.samples().end(), out.samples().begin()));
  }
}

TEST_CASE("a warp by whole and by fractional pixels finds the values of a smooth picture") {
  WorkerPool pool(1);
  const auto image = texture(40, 60);
  Image<float> cubic, radiance, linear;
  for (const float dx : {3.f, -2.f, 0.5f, 1.34375f}) {
    warp_cubic(image, uniform_vectors(40, 60, dx, 1), cubic, pool);
    warp_radiance(image, uniform_vectors(40, 60, dx, 1), radiance, pool);
    warp_linear(image, uniform_vectors(40, 60, dx, 1), linear, pool);
    for (int y = 6; y < 34; ++y)
      for (int x = 6; x < 54; ++x) {
        const double truth =
            2 + std::sin(0.31 * (x + static_cast<double>(dx)) + 1) * std::cos(0.23 * (y + 1));
        REQUIRE(cubic.at(1, y, x) == Approx(truth).margin(0.004));
        REQUIRE(radiance.at(1, y, x) == Approx(truth).margin(0.008));
        REQUIRE(linear.at(1, y, x) == Approx(truth).margin(0.02));
      }
  }
}

TEST_CASE("radiance between a dark place and a bright one rings on neither side") {
  WorkerPool pool(1);
  Image<float> edge(1, 6, 16), out;
  for (int y = 0; y < 6; ++y)
    for (int x = 0; x < 16; ++x) edge.at(0, y, x) = x < 8 ? 0.01f : 50;
  for (int times = 0; times < 8; ++times) {  // as a state that is carried on and on
    warp_radiance(edge, uniform_vectors(6, 16, times % 2 == 0 ? 0.5f : -0.5f, 0), out, pool);
    std::swap(edge, out);
  }
  CHECK(edge.at(0, 3, 2) == Approx(0.01f).epsilon(0.02));
  CHECK(edge.at(0, 3, 13) == Approx(50).epsilon(0.02));
  for (const float v : edge.samples()) CHECK((v > 0.005f && v < 100));
}

TEST_CASE("a flow that leads nowhere repeats the border and reads nothing outside") {
  constexpr int kRows = 5, kCols = 7;
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  WorkerPool pool(1);
  const auto image = texture(kRows, kCols);
  Image<float> radiance, linear;
  // a place that is no number is taken for one before the first pixel
  for (const float wild : {1e9f, -1e9f, kInfinity, -kInfinity, std::numeric_limits<float>::quiet_NaN()}) {
    warp_radiance(image, uniform_vectors(kRows, kCols, wild, wild), radiance, pool);
    warp_linear(image, uniform_vectors(kRows, kCols, wild, wild), linear, pool);
    const int row = wild > 0 ? kRows - 1 : 0, col = wild > 0 ? kCols - 1 : 0;
    CAPTURE(wild);
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < kRows; ++y)
        for (int x = 0; x < kCols; ++x) {
          REQUIRE(linear.at(c, y, x) == Approx(image.at(c, row, col)));
          REQUIRE(radiance.at(c, y, x) == Approx(image.at(c, row, col)).epsilon(0.005));
        }
  }
}
