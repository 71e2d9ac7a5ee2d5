// The effects of the sensor, each against its formula.
#include <cmath>
#include <vector>

#include "hal/sim/effects/hot_pixels.h"
#include "hal/sim/effects/mosaic.h"
#include "hal/sim/effects/noise.h"
#include "hal/sim/effects/quantiser.h"
#include "hal/sim/effects/response_curve.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

struct Moments {
  double mean = 0, variance = 0;
};
Moments moments_of(const std::vector<float>& values) {
  Moments m;
  for (const float v : values) m.mean += static_cast<double>(v);
  m.mean /= static_cast<double>(values.size());
  for (const float v : values)
    m.variance += (static_cast<double>(v) - m.mean) * (static_cast<double>(v) - m.mean);
  m.variance /= static_cast<double>(values.size());
  return m;
}

}  // namespace

TEST_CASE("noise has the mean and the variance of shot plus read noise, in the dark and in the light") {
  const Noise noise({.read_noise_e = 8}, 3);
  for (const float mean : {0.f, 0.7f, 5.f, 19.f, 21.f, 300.f, 4000.f}) {
    std::vector<float> electrons(100'000, mean);
    noise.apply(electrons, 1e6f, 1, 0);
    const Moments m = moments_of(electrons);
    const double variance = static_cast<double>(mean) + 64;
    INFO("mean of " << mean << " electrons");
    CHECK(m.mean == Approx(static_cast<double>(mean)).margin(5 * std::sqrt(variance / 1e5)));
    CHECK(m.variance == Approx(variance).epsilon(5 * std::sqrt(2e-5)));
  }
}

TEST_CASE("the noise of neighbours is independent, where one is dark and the other bright too") {
  const Noise noise({.read_noise_e = 0}, 3);
  constexpr double kPairs = 100'000;
  for (const float first : {10.f, 1000.f})
    for (const float second : {10.f, 1000.f}) {
      std::vector<float> electrons;
      while (electrons.size() < 2 * static_cast<std::size_t>(kPairs))
        electrons.push_back(first), electrons.push_back(second);
      noise.apply(electrons, 1e6f, 1, 0);
      double sum = 0;
      for (std::size_t i = 0; i < electrons.size(); i += 2)
        sum += static_cast<double>((electrons[i] - first) * (electrons[i + 1] - second));
      INFO(first << " and " << second << " electrons");
      CHECK(sum / kPairs / std::sqrt(static_cast<double>(first * second)) ==
            Approx(0).margin(5 / std::sqrt(kPairs)));
    }
}

TEST_CASE("charge is clipped at the full well before it is read") {
  const Noise noise({.read_noise_e = 2}, 3);
  std::vector<float> electrons(10'000, 50'000.f);
  noise.apply(electrons, 1000, 1, 0);
  const Moments m = moments_of(electrons);
  CHECK(m.mean == Approx(1000).margin(0.1));
  CHECK(m.variance == Approx(4).epsilon(0.1));
}

TEST_CASE("a pixel's noise depends on the frame and on the pixel, not on the row it is computed with") {
  const Noise noise({}, 3);
  std::vector<float> whole(1000, 100.f), part(400, 100.f), later(1000, 100.f);
  noise.apply(whole, 6000, 5, 0);
  noise.apply(part, 6000, 5, 600);
  noise.apply(later, 6000, 6, 0);
  CHECK(std::equal(part.begin(), part.end(), whole.begin() + 600));
  CHECK(whole != later);
}

TEST_CASE("quantisation rounds to the nearest code above the black level and saturates") {
  const Quantiser eight(8, 0), twelve(12, 256);
  CHECK(eight.code(0) == 0);
  CHECK(eight.code(0.5f) == 128);  // 127.5
  CHECK(eight.code(100.4f / 255) == 100);
  CHECK(eight.code(100.6f / 255) == 101);
  CHECK(eight.code(7) == 255);
  CHECK(eight.code(-7) == 0);
  CHECK(twelve.code(0) == 256);
  CHECK(twelve.code(1) == 4095);
  CHECK(twelve.code(0.5f) == 2176);   // 256 + 3839 / 2, rounded up
  CHECK(twelve.code(-0.01f) == 218);  // below black the noise is still seen
}

TEST_CASE("response curves run from 0 to 1, never fall, and the table is the formula") {
  for (const CurveShape shape : {CurveShape::Gamma, CurveShape::Film}) {
    const ResponseCurve curve(shape);
    for (int channel = 0; channel < 3; ++channel) {
      CHECK(curve.value(channel, 0) == Approx(0).margin(1e-6));
      CHECK(curve.value(channel, 1) == Approx(1));
      CHECK(curve.value(channel, 2) == Approx(1));
      float before = 0;
      for (int i = 1; i <= 3000; ++i) {
        const float x = static_cast<float>(i) / 3000, value = curve.value(channel, x);
        REQUIRE(value > before);
        REQUIRE(static_cast<double>(value) ==
                Approx(ResponseCurve::exact(shape, channel, static_cast<double>(x))).margin(1e-4));
        before = value;
      }
    }
  }
  CHECK(ResponseCurve::exact(CurveShape::Gamma, 0, 0.5) == Approx(std::pow(0.5, 1 / 2.2)));
}

TEST_CASE("a mosaic keeps the colour that its order says") {
  Image<float> light(3, 2, 4);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < 2; ++y)
      for (int x = 0; x < 4; ++x) light.at(c, y, x) = static_cast<float>(c);
  struct Order {
    PixelLayout layout;
    std::vector<float> even_row, odd_row;
  };
  for (const Order& order : {Order{PixelLayout::BayerRggb, {0, 1, 0, 1}, {1, 2, 1, 2}},
                             Order{PixelLayout::BayerGrbg, {1, 0, 1, 0}, {2, 1, 2, 1}},
                             Order{PixelLayout::BayerGbrg, {1, 2, 1, 2}, {0, 1, 0, 1}},
                             Order{PixelLayout::BayerBggr, {2, 1, 2, 1}, {1, 0, 1, 0}}}) {
    const Mosaic mosaic(order.layout);
    std::vector<float> row(4);
    mosaic.pick_row(light, 0, row);
    CHECK(row == order.even_row);
    mosaic.pick_row(light, 1, row);
    CHECK(row == order.odd_row);
    CHECK(mosaic.channel(1, 3) == static_cast<int>(order.odd_row[3]));
  }
}

TEST_CASE("hot pixels stay where they are, are as many as asked, and grow with the exposure") {
  const HotPixels hot({.share = 0.01, .mean_rate_e_per_s = 1000}, 9, 3, 100, 200);
  const HotPixels same({.share = 0.01, .mean_rate_e_per_s = 1000}, 9, 3, 100, 200);
  std::size_t count = 0;
  double rate = 0;
  for (int channel = 0; channel < 3; ++channel)
    for (int y = 0; y < 100; ++y) {
      std::vector<float> once(200, 10.f), twice(200, 10.f);
      hot.add(channel, y, 0.01f, once);
      same.add(channel, y, 0.02f, twice);
      for (const auto& leak : hot.in_row(channel, y)) {
        const auto x = static_cast<std::size_t>(leak.x);
        CHECK(once[x] - 10 == Approx(leak.rate_e_per_s * 0.01f).margin(1e-4));
        CHECK(twice[x] - 10 == Approx(2 * (once[x] - 10)).margin(1e-4));
        rate += static_cast<double>(leak.rate_e_per_s), ++count;
      }
    }
  CHECK(static_cast<double>(count) == Approx(600).margin(125));  // five standard deviations
  CHECK(rate / static_cast<double>(count) == Approx(1000).epsilon(0.2));
}
