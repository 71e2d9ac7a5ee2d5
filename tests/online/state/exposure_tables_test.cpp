#include "online/state/exposure_tables.h"

#include <vector>

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

NoiseModel noiseless() {
  NoiseModel noise;
  noise.full_well = 1e9f, noise.read_noise = 0, noise.code_noise = 0, noise.code_step = 0;
  return noise;
}

}  // namespace

TEST_CASE("a code near black is a bound: whatever the noise, it does not tell dark from darker") {
  const Response response = Response::gamma(2.2f);
  const ExposureTables tables(response, noiseless(), 1);
  const float black = response.inverse(0)[4];
  CHECK(tables.variance(0, 0) == Approx(black * black).epsilon(0.05));
  CHECK(tables.variance(0, response.inverse(0)[60]) < 0.1f * black * black);
}

TEST_CASE("what is not known of the response is not known of a sample") {
  const Response known = Response::gamma(2.2f);
  std::array<Response::Curve, 3> inverse{}, uncertainty{};
  for (int c = 0; c < 3; ++c) {
    inverse[static_cast<std::size_t>(c)] = known.inverse(c);
    uncertainty[static_cast<std::size_t>(c)].fill(0.2f);
  }
  const ExposureTables tables(Response(inverse, uncertainty), noiseless(), 0.25f);
  const float radiance = 4 * known.inverse(1)[100];
  CHECK(tables.variance(1, radiance) == Approx(0.04f * radiance * radiance).epsilon(0.05));
}
