// What a code can and cannot say about a radiance: values of the losses, not their gradients, which agree
// with finite differences whatever the value is (../gradient_test.cpp).
#include "online/scene/hash_grid/fit/losses/photometric.h"

#include "online/scene/hash_grid/fit/losses/warped_photometric.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

struct Answer {
  double loss = 0, slope = 0;  // summed over the channels
};

// Three channels that measured `code`, 0..1, against one radiance of exposure 1 under a square-root response.
Answer photometric(float code, double radiance) {
  static const LearnedResponse<double> kResponse{Response::gamma(2)};
  const double radiances[3] = {radiance, radiance, radiance};
  const float measured[3] = {code, code, code};
  double d[3] = {0, 0, 0};
  const double loss = photometric_loss(1.0, kResponse, 1.0, radiances, measured, d,
                                       static_cast<LearnedResponse<double>::Gradient*>(nullptr));
  return {loss, d[0] + d[1] + d[2]};
}

}  // namespace

TEST_CASE("a clipped code is a bound: what is brighter costs nothing, what is darker does", "[field]") {
  for (const double brighter : {1.01, 2.0, 50.0}) {
    INFO("radiance " << brighter);
    CHECK(photometric(1, brighter).loss == 0);
    CHECK(photometric(1, brighter).slope == 0);
  }
  CHECK(photometric(1, 0.25).loss == Approx(0.5).margin(0.02));
  CHECK(photometric(1, 0.25).slope < -0.5);
}

TEST_CASE("a black code is a bound: what is darker costs nothing, what is brighter does", "[field]") {
  constexpr float kAlmostBlack = 0.0036f;
  CHECK(photometric(kAlmostBlack, 1e-7).loss == 0);
  CHECK(photometric(kAlmostBlack, 1e-7).slope == 0);
  CHECK(photometric(kAlmostBlack, 0.25).loss == Approx(0.49).margin(0.02));
}

TEST_CASE("a code between the ends pulls from both sides", "[field]") {
  CHECK(photometric(0.5f, 0.16).slope < 0);
  CHECK(photometric(0.5f, 0.36).slope > 0);
  CHECK(photometric(0.5f, 0.25).loss == Approx(0).margin(1e-3));
}

TEST_CASE("the warped picture counts as far as the neighbour sees the point", "[field]") {
  const LearnedResponse<double> response{Response::gamma(2)};
  const double radiance[3] = {0.5, 0.5, 0.5};
  const float measured[3] = {0.2f, 0.2f, 0.2f};
  const auto loss = [&](double visible, double* d_radiance, double& d_visible) {
    return warped_photometric_loss(1.0, response, 1.0, radiance, measured, visible, d_radiance, d_visible);
  };
  double d_full[3] = {0, 0, 0}, d_third[3] = {0, 0, 0}, d_hidden[3] = {0, 0, 0};
  double d_visible = 0, ignored = 0;
  const double full = loss(1, d_full, d_visible);
  CHECK(full > 0.4);
  CHECK(d_visible == Approx(full));
  CHECK(loss(1.0 / 3, d_third, ignored) == Approx(full / 3));
  CHECK(loss(0, d_hidden, ignored) == 0);
  for (int c = 0; c < 3; ++c) {
    CHECK(d_full[c] > 0);
    CHECK(d_third[c] == Approx(d_full[c] / 3));
    CHECK(d_hidden[c] == 0);
  }
}
