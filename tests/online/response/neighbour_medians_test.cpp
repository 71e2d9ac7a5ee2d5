#include "online/response/neighbour_medians.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/support/coded_frame.h"
#include "tests/support/moving_scene.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

Image<float> random_codes(int rows, int cols) {
  std::uint64_t pixel = 0;
  return test::coded_frame(
             rows, cols,
             [&](int, int, int) { return 128 + 40 * static_cast<float>(test::MovingScene::noise(++pixel)); })
      .codes;
}

// Of what stands around a pixel, the border repeated, by sorting it.
float sorted_middle(const Image<float>& codes, int channel, int y, int x) {
  std::vector<float> around;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx)
      around.push_back(codes.at(channel, std::clamp(y + dy, 0, codes.rows() - 1),
                                std::clamp(x + dx, 0, codes.cols() - 1)));
  std::sort(around.begin(), around.end());
  return around[4];
}

}  // namespace

TEST_CASE(
    "a neighbour median is the fifth of nine codes, at the border too, of the lines that are asked for") {
  struct Size {
    int rows, cols;
  };
  for (const auto& [rows, cols] : {Size{17, 23}, {1, 9}, {9, 1}, {1, 1}, {2, 2}})
    for (const int step : {1, 2, 5}) {
      const Image<float> codes = random_codes(rows, cols);
      for (int channel = 0; channel < 3; ++channel) {
        CAPTURE(rows, cols, step, channel);
        std::vector<float> expected;
        for (int y = 0; y < rows; y += step)
          for (int x = 0; x < cols; ++x) expected.push_back(sorted_middle(codes, channel, y, x));
        CHECK(neighbour_medians(codes, channel, step) == expected);
      }
    }
}

TEST_CASE("a response and an exposure leave neighbour medians the medians of the light") {
  Image<float> light = random_codes(31, 40), curved = random_codes(31, 40);
  const auto response = [](float x) { return 255 * std::pow(x / 255, 0.4f); };
  std::ranges::transform(light.samples(), curved.samples().begin(), response);
  std::vector<float> medians = neighbour_medians(light, 1, 1);
  std::ranges::transform(medians, medians.begin(), response);
  CHECK(neighbour_medians(curved, 1, 1) == medians);
}

TEST_CASE("of white noise neighbour medians leave less than a fifth of the variance") {
  const auto variance = [](const std::vector<float>& codes) {
    double sum = 0, squares = 0;
    for (const float code : codes) {
      const double off = static_cast<double>(code) - 128;
      sum += off, squares += off * off;
    }
    const auto count = static_cast<double>(codes.size());
    return squares / count - sum / count * sum / count;
  };
  const Image<float> codes = random_codes(200, 300);
  const std::vector<float> plain(codes.row(0, 0), codes.row(0, 0) + codes.plane_size());
  const double left = variance(neighbour_medians(codes, 0, 1)) / variance(plain);
  CHECK(left > 0.15);
  CHECK(left < 0.2);
}
