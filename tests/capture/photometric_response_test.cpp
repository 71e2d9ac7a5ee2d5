#include "capture/photometric_response.h"

#include <algorithm>
#include <cmath>

#include "online/response/response.h"

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

// ln E of code `b` over that of code `a`.
float ratio_of(const PhotometricResponse& response, float a, float b) {
  return response.log_exposure(b) - response.log_exposure(a);
}

TEST_CASE("before any fit the less is known of the codes, the wider a ratio is left open", "[capture]") {
  const auto stated = PhotometricResponse::before_any_fit(true, BlackLevel(16));
  const auto unreported = PhotometricResponse::before_any_fit(true, std::nullopt);
  const auto processed = PhotometricResponse::before_any_fit(false, std::nullopt);
  CHECK(ratio_of(stated, 66, 116) == Approx(std::log(2)));
  CHECK(ratio_of(processed, 66, 116) > std::log(2));  // a camera's curve
  CHECK(stated.stretch() < unreported.stretch());
  CHECK(unreported.stretch() < processed.stretch());
}

TEST_CASE("a black level does not make processed codes linear", "[capture]") {
  const auto stated = PhotometricResponse::before_any_fit(false, BlackLevel(16));
  const auto not_stated = PhotometricResponse::before_any_fit(false, std::nullopt);
  CHECK(ratio_of(stated, 66, 116) == ratio_of(not_stated, 66, 116));
}

TEST_CASE("a raw code so far above black is the same light, whatever the black level", "[capture]") {
  for (const float black : {0.f, 16.f, 40.f}) {
    const auto response = PhotometricResponse::before_any_fit(true, BlackLevel(black));
    for (const float above : {25.5f, 102.f, 204.f}) {
      CAPTURE(black, above);
      CHECK(response.log_exposure(black + above) == Approx(std::log(above / 255)));
    }
  }
}

TEST_CASE("what a fit has learned of raw codes is the same light as codes of another black level",
          "[capture]") {
  PhotometricResponse::Curve inverse;
  for (std::size_t z = 0; z < inverse.size(); ++z) inverse[z] = static_cast<float>(z) / 255;
  for (const float black : {0.f, 16.f, 64.f}) {
    const auto learned = PhotometricResponse::known(inverse, BlackLevel(black));
    const auto other = PhotometricResponse::before_any_fit(true, BlackLevel(40));
    for (const float above : {25.f, 102.f, 180.f}) {
      CAPTURE(black, above);
      CHECK(learned.log_exposure(black + above) == Approx(other.log_exposure(40 + above)).margin(1e-4));
    }
  }
}

TEST_CASE("codes that are too dark or may be clipped have no exposure", "[capture]") {
  const auto response = PhotometricResponse::before_any_fit(true, BlackLevel(16));
  CHECK(response.log_exposure(17) < -1e30f);
  CHECK(response.log_exposure(252) > 1e30f);
}

TEST_CASE("of a learned response that is level from white on, codes from near white on are clipped") {
  Response::Curve inverse{};
  for (std::size_t z = 0; z < inverse.size(); ++z) inverse[z] = std::min(1.f, static_cast<float>(z) / 200);
  const Response learned({inverse, inverse, inverse});
  const auto response = PhotometricResponse::known(learned.inverse(1), BlackLevel());
  CHECK(response.clipped_from() == Approx(200 * 250 / 255.).margin(1));
  CHECK(std::isfinite(response.log_exposure(180)));
  CHECK(std::isinf(response.log_exposure(200)));
  CHECK(PhotometricResponse::known(Response::gamma(2.2f).inverse(1), BlackLevel()).clipped_from() == 250);
}

}  // namespace
}  // namespace hdrcam
