#include "hal/sim/counter_random.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("a counter's numbers depend on seed, stream, part and counter, and on nothing else") {
  const CounterRandom random(7, 1, 2);
  CHECK(random.bits(5) == CounterRandom(7, 1, 2).bits(5));
  CHECK(random.bits(5) != random.bits(6));
  CHECK(random.bits(5) != CounterRandom(8, 1, 2).bits(5));
  CHECK(random.bits(5) != CounterRandom(7, 2, 2).bits(5));
  CHECK(random.bits(5) != CounterRandom(7, 1, 3).bits(5));
}

TEST_CASE("uniform and normal numbers have the moments of their distributions") {
  constexpr int kCount = 200'000;
  const CounterRandom random(11, 3);
  double uniform = 0, uniform2 = 0, normal = 0, normal2 = 0, normal4 = 0, product = 0;
  for (std::uint64_t i = 0; i < kCount; ++i) {
    const double u = random.uniform(i);
    REQUIRE(u >= 0);
    REQUIRE(u < 1);
    uniform += u, uniform2 += u * u;
    const auto [a, b] = random.normals(i);
    normal += a, normal2 += a * a, normal4 += a * a * a * a, product += a * b;
  }
  // Margins of five standard errors.
  CHECK(uniform / kCount == Approx(0.5).margin(0.0033));
  CHECK(uniform2 / kCount == Approx(1.0 / 3).margin(0.0034));
  CHECK(normal / kCount == Approx(0).margin(0.012));
  CHECK(normal2 / kCount == Approx(1).margin(0.016));
  CHECK(normal4 / kCount == Approx(3).margin(0.12));
  CHECK(product / kCount == Approx(0).margin(0.012));
}
