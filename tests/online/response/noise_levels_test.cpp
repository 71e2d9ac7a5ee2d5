#include "online/response/noise_levels.h"

#include <algorithm>
#include <cmath>

#include "capture/demosaic.h"
#include "capture/to_exposed_frame.h"
#include "online/response/response_estimator.h"
#include "tests/support/coded_frame.h"
#include "tests/support/moving_scene.h"
#include "tests/support/response_error.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using test::response_error;

namespace {

constexpr int kRows = 192, kCols = 256;
constexpr double kFullWell = 3000, kReadNoise = 12;  // electrons

double spread_of_light(double x) { return std::sqrt(x / kFullWell + std::pow(kReadNoise / kFullWell, 2)); }

double noise_at(int frame, int channel, int y, int x) {
  return test::MovingScene::noise(
      static_cast<std::uint64_t>(((frame * 3 + channel) * kRows + y) * kCols + x + 1));
}

// Smooth, over ten stops.
double scene_at(int c, int y, int x) {
  return std::exp2(-5 + 5 * std::sin(x * 0.03 + 0.4 * c) * std::cos(y * 0.025));
}

// Frames of that scene, as a sensor of that noise records them.
ExposedFrame recorded(int index, float exposure, const Response& response) {
  ExposedFrame frame = test::coded_frame(kRows, kCols, [&](int c, int y, int x) {
    const double light = std::min(1.0, static_cast<double>(exposure) * scene_at(c, y, x));
    const double seen = std::clamp(light + noise_at(index, c, y, x) * spread_of_light(light), 0.0, 1.0);
    return std::round(response.code_of(c, static_cast<float>(seen)));
  });
  frame.index = index, frame.exposure = exposure;
  return frame;
}

template <class Filter>
std::size_t levels_after(Filter&& filter) {
  NoiseLevels noise;
  for (int i = 0; i < 6; ++i) {
    ExposedFrame frame = recorded(i, i % 2 == 0 ? 0.06f : 1, Response::gamma(2.2f));
    filter(frame.codes);
    noise.add(frame);
  }
  std::size_t count = 0;
  for (const auto& channel : noise.levels()) count += channel.size();
  return count;
}

Image<float> blurred(const Image<float>& codes) {
  Image<float> out(3, kRows, kCols);
  std::copy_n(codes.samples().data(), codes.size(), out.samples().data());
  for (int c = 0; c < 3; ++c)
    for (int y = 1; y + 1 < kRows; ++y)
      for (int x = 1; x + 1 < kCols; ++x) {
        float sum = 0;
        for (int dy = -1; dy <= 1; ++dy)
          for (int dx = -1; dx <= 1; ++dx) sum += codes.at(c, y + dy, x + dx);
        out.at(c, y, x) = std::round(sum / 9);
      }
  return out;
}

}  // namespace

TEST_CASE("the spread of codes is that of the sensor's noise over the slope of the response") {
  for (const float exponent : {1.f, 2.2f}) {
    const Response response = Response::gamma(exponent);
    NoiseLevels noise;
    for (int i = 0; i < 6; ++i) noise.add(recorded(i, i % 2 == 0 ? 0.06f : 1, response));
    const auto levels = noise.levels();
    for (int c = 0; c < 3; ++c) {
      const auto& channel = levels[static_cast<std::size_t>(c)];
      REQUIRE(channel.size() >= 8);
      CHECK(channel.front().code < 50);
      CHECK(channel.back().code > 150);
      double square = 0;
      for (const NoiseLevel& level : channel) {
        const double x = static_cast<double>(response.exposure_of(c, level.code));
        const double expected = spread_of_light(x) / static_cast<double>(response.slope(c, level.code));
        square += std::pow(std::log(static_cast<double>(level.spread) / expected), 2);
      }
      INFO("gamma " << exponent << ", channel " << c << ", " << channel.size() << " levels");
      CHECK(std::sqrt(square / static_cast<double>(channel.size())) < 0.12);
    }
  }
}

TEST_CASE("noise that codes of 8 bits hide is found where codes have 12 bits") {
  constexpr double kLargeWell = 3e5;  // electrons: its noise is a quarter of a code of 8 bits
  const Response response = Response::gamma(2.2f);
  const auto shot = [&](double light) { return std::sqrt(light / kLargeWell); };
  const auto levels_of = [&](int bits) {
    const float step = code_scale(bits);
    NoiseLevels noise(step, bits);
    for (int i = 0; i < 6; ++i) {
      ExposedFrame frame = test::coded_frame(kRows, kCols, [&](int c, int y, int x) {
        const double light = std::min(1.0, (i % 2 == 0 ? 0.06 : 1) * scene_at(c, y, x));
        const double seen = std::clamp(light + noise_at(i, c, y, x) * shot(light), 0.0, 1.0);
        return std::round(response.code_of(c, static_cast<float>(seen)) / step) * step;
      });
      frame.index = i;
      noise.add(frame);
    }
    return noise.levels();
  };
  for (const auto& channel : levels_of(8)) CHECK(channel.empty());
  for (const auto& channel : levels_of(12)) {
    REQUIRE(channel.size() >= 8);
    double square = 0;
    for (const NoiseLevel& level : channel) {
      const double x = static_cast<double>(response.exposure_of(0, level.code));
      const double expected = shot(x) / static_cast<double>(response.slope(0, level.code));
      square += std::pow(std::log(static_cast<double>(level.spread) / expected), 2);
    }
    CHECK(std::sqrt(square / static_cast<double>(channel.size())) < 0.12);
  }
}

TEST_CASE("what compression, filters and demosaicing leave is not taken for the sensor's own noise") {
  CHECK(levels_after([](Image<float>&) {}) >= 24);
  SECTION("colours at less than full size, so that the fine part of all channels is one") {
    CHECK(levels_after([](Image<float>& codes) {
            const Image<float> coarse = blurred(codes);
            for (int y = 0; y < kRows; ++y)
              for (int x = 0; x < kCols; ++x) {
                float fine = 0;
                for (int c = 0; c < 3; ++c) fine += (codes.at(c, y, x) - coarse.at(c, y, x)) / 3;
                for (int c = 0; c < 3; ++c) codes.at(c, y, x) = std::round(coarse.at(c, y, x) + fine);
              }
          }) == 0);
  }
  SECTION("noise reduction") {
    CHECK(levels_after([](Image<float>& codes) { codes = blurred(codes); }) == 0);
  }
  SECTION("one colour per site") {
    CHECK(levels_after([](Image<float>& codes) {
            Image<std::uint16_t> mosaic(1, kRows, kCols);
            for (int y = 0; y < kRows; ++y)
              for (int x = 0; x < kCols; ++x)
                mosaic.at(0, y, x) = static_cast<std::uint16_t>(codes.at(y % 2 + x % 2, y, x));
            demosaic(mosaic, PixelLayout::BayerRggb, kMaxCode, codes);
          }) == 0);
  }
}

TEST_CASE("frames of another gain, whose noise is another, and damaged ones are left out") {
  const Response response = Response::gamma(2.2f), another = Response::gamma(1);
  NoiseLevels alone, mixed;
  for (int i = 0; i < 6; ++i) {
    const float exposure = i % 2 == 0 ? 0.06f : 1;
    const ExposedFrame frame = recorded(i, exposure, response);
    alone.add(frame), mixed.add(frame);
    ExposedFrame other = recorded(i + 6, exposure, another);
    other.facts.analogue_gain = 4;
    mixed.add(other);
    other.facts.analogue_gain = 1, other.facts.flags |= kFrameDamaged;
    mixed.add(other);
  }
  for (std::size_t c = 0; c < 3; ++c) {
    const auto expected = alone.levels()[c], found = mixed.levels()[c];
    REQUIRE(found.size() == expected.size());
    for (std::size_t i = 0; i < found.size(); ++i) CHECK(found[i].spread == expected[i].spread);
  }
}

TEST_CASE(
    "where two exposures share hardly a code, the sensor's noise tells the curve, full well and read noise") {
  struct Row {
    float exponent;  // far from the mean of real cameras
    double left;     // of the error without it: matches tell less of a curve that is nearly straight
  };
  for (const auto& [exponent, left] : {Row{1.1f, 0.35}, {3.2f, 0.9}}) {
    const Response response = Response::gamma(exponent);
    ResponseEstimator blind, seeing;
    ExposedFrame before;
    for (int i = 0; i < 6; ++i) {
      ExposedFrame frame = recorded(i, i % 2 == 0 ? 0.015f : 1, response);
      seeing.add_noise(frame);
      if (i > 0)
        for (ResponseEstimator* estimator : {&blind, &seeing}) CHECK(estimator->add_pair(before, frame));
      before = std::move(frame);
    }
    const ResponseEstimate without = blind.estimate({}), with = seeing.estimate({});
    INFO("gamma " << exponent << ": " << response_error(without.response, response) << " and "
                  << response_error(with.response, response) << " stop");
    CHECK(response_error(with.response, response) < 0.15);
    CHECK(response_error(with.response, response) < left * response_error(without.response, response));
    CHECK_FALSE(without.noise.has_value());
    REQUIRE(with.noise.has_value());
    CHECK(with.noise->full_well == Approx(kFullWell).epsilon(0.25));
    CHECK(with.noise->read_noise == Approx(kReadNoise).epsilon(0.25));
  }
}
