#include "online/scene/hash_grid/fit/learned_response.h"

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
