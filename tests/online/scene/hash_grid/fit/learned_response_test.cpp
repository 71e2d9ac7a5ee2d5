#include "online/scene/hash_grid/fit/learned_response.h"

#include <cmath>

#include "online/scene/hash_grid/field/random.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("the response of the fit starts at the one that it refines, linear or nearly") {
  for (const Response& response : {Response::linear(), Response::gamma(1.4f)}) {
    const LearnedResponse<double> learned(response);
    for (const float code : {2.f, 8.f, 64.f, 128.f, 250.f}) {
      CAPTURE(code);
      const auto exposure = static_cast<double>(response.exposure_of(1, code));
      CHECK(255 * learned.evaluate(1, exposure).value == Approx(static_cast<double>(code)).margin(0.06));
    }
  }
}

TEST_CASE("the learned response starts as the response it is given and stays monotone", "[isa][field]") {
  LearnedResponse<double> learned{Response::gamma(2.2f)};
  for (double x : {1e-4, 1e-3, 0.01, 0.1, 0.5, 0.9})
    CHECK(learned.evaluate(1, x).value == Approx(std::pow(x, 1 / 2.2)).margin(0.003));
  CHECK(learned.evaluate(0, 1.0).value == Approx(1));
  CHECK(learned.evaluate(0, 4.0).value == Approx(1.005));
  Pcg32 chance(8);
  for (auto& channel : learned.increments())
    for (double& increment : channel) increment = static_cast<double>(chance.uniform(-30, 30));
  learned.rebuild();
  for (int c = 0; c < 3; ++c)
    for (int j = 1; j < LearnedResponse<double>::kPoints; ++j)
      CHECK(learned.point(c, j) >= learned.point(c, j - 1));
}

TEST_CASE("the learned response leaks: continuous at 0 and 1, its derivative right and never zero",
          "[isa][field]") {
  const LearnedResponse<double> learned{Response::gamma(2.2f)};
  for (int c = 0; c < 3; ++c) {
    for (const double edge : {0.0, 1.0}) {
      const double below = learned.evaluate(c, edge - 1e-9).value,
                   above = learned.evaluate(c, edge + 1e-9).value;
      CHECK(above == Approx(below).margin(1e-4));
      CHECK(below == Approx(edge).margin(1e-4));
    }
    for (const double x : {-3.0, -0.1, 0.013, 0.4, 1.2, 2.0, 50.0}) {
      const double h = 1e-6;  // of ln |x|
      const double numeric =
          (learned.evaluate(c, x * std::exp(h)).value - learned.evaluate(c, x * std::exp(-h)).value) /
          (2 * h);
      const double d_log = learned.evaluate(c, x).d_log;
      INFO("channel " << c << " at " << x);
      CHECK(d_log == Approx(numeric).epsilon(1e-4));
      CHECK(d_log / x > 0);  // brighter is never a smaller code
    }
  }
}
