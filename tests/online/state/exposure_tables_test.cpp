#include "online/state/exposure_tables.h"

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

TEST_CASE(
    "compression hides small textures whole and some codes of large ones, a clean camera's codes hide none") {
  const Response response = Response::gamma(2.2f);
  NoiseModel compressed = noiseless();
  compressed.code_noise = 1;
  const ExposureTables tables(response, compressed, 0.25f), clean(response, noiseless(), 0.25f);
  const float radiance = 4 * response.inverse(1)[128];
  const float per_code = 4 * (response.inverse(1)[129] - response.inverse(1)[128]);
  const float codes2 = per_code * per_code;
  CHECK(tables.doubts_textures());
  CHECK(tables.hidden_texture(1, radiance, 0.25f * codes2) == Approx(0.25f * codes2).epsilon(0.05));
  CHECK(tables.hidden_texture(1, radiance, 1e4f * codes2) == Approx(16 * codes2).epsilon(0.05));
  CHECK_FALSE(clean.doubts_textures());
  CHECK(clean.hidden_texture(1, radiance, 16 * codes2) == 0);
}

TEST_CASE("of compression's noise more counts than smooth places show, of a clean camera's as much") {
  const Response response = Response::gamma(2.2f);
  const auto variance_in_codes = [&](float code_noise) {
    NoiseModel noise = noiseless();
    noise.code_noise = code_noise;
    const ExposureTables tables(response, noise, 1);
    const float per_code = response.slope(1, 128);
    return tables.variance(1, response.inverse(1)[128]) / (per_code * per_code);
  };
  CHECK(variance_in_codes(0.25f) == Approx(0.0625f).epsilon(0.05));
  CHECK(variance_in_codes(1) == Approx(4).epsilon(0.05));
  CHECK(variance_in_codes(2) == Approx(16).epsilon(0.05));
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
