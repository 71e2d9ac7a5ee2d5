#include "online/response/exposure_corrections.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE(
    "an exposure is off by as much as the nearest one that was learned, and one far from all is as stated") {
  ExposureCorrections corrections;
  const auto ln_off = [&](float exposure) { return std::log(corrections.corrected(exposure) / exposure); };
  CHECK(corrections.corrected(0.7f) == 0.7f);  // nothing was learned
  corrections.set(0.25f, -0.04);
  corrections.set(1, 0.1);
  corrections.set(1.03f, 0.2);  // 2.7 / 64 stop
  CHECK(ln_off(0.25f) == Approx(-0.04).epsilon(1e-3));
  CHECK(ln_off(1) == Approx(0.1).epsilon(1e-3));
  CHECK(ln_off(1.03f) == Approx(0.2).epsilon(1e-3));
  CHECK(ln_off(1.01f) == Approx(0.1).epsilon(1e-3));
  CHECK(ln_off(1.025f) == Approx(0.2).epsilon(1e-3));
  for (const float jitter : {0.97f, 0.985f, 1.015f, 1.03f}) {
    INFO("jitter " << jitter);
    CHECK(ln_off(0.25f * jitter) == Approx(-0.04).epsilon(1e-3));
  }
  const std::vector<ExposureCorrection> learned = corrections.learned();
  REQUIRE(learned.size() == 3);
  CHECK(learned[0].stated == 0.25f);
  CHECK(learned[0].stops == Approx(-0.04 / std::numbers::ln2));
  CHECK(learned[2].stated == 1.03f);
  CHECK(learned[2].stops == Approx(0.2 / std::numbers::ln2));
  for (const float other : {0.1f, 0.23f, 0.5f, 0.93f, 1.12f, 4.f})
    CHECK(corrections.corrected(other) == other);
}
