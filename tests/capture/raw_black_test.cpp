#include "capture/raw_black.h"

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

const BlackLevel kBlack(16), kOther(24);

TEST_CASE("a black level that comes with a frame holds for all where nobody else states one", "[capture]") {
  RawBlack black({}, CameraCapabilities(), {}, true);
  CHECK(black.unreported());
  CHECK_FALSE(black.adopt(std::nullopt));
  const double widest = black.first_response().stretch();
  REQUIRE(black.adopt(kBlack));
  CHECK_FALSE(black.unreported());
  CHECK(black.first_response().stretch() < widest);
  CHECK(black.stated(std::nullopt) == kBlack);
  CHECK_FALSE(black.adopt(kOther));
  CHECK(black.stated(kOther) == kOther);
  CHECK(black.stated() == kBlack);
}

TEST_CASE(
    "what the user or the camera states, or the table of sensors, is not replaced by what a frame states",
    "[capture]") {
  CameraCapabilities camera;
  camera.black_level = kBlack;
  for (RawBlack black : {RawBlack(kBlack, {}, {}, true), RawBlack({}, camera, {}, true),
                         RawBlack({}, {}, KnownSensor{{}, kBlack}, true)}) {
    CHECK_FALSE(black.adopt(kOther));
    CHECK(black.stated() == kBlack);
  }
}

TEST_CASE("neither processed codes nor a response that was learned take a black level from a frame",
          "[capture]") {
  RawBlack processed({}, {}, {}, false), learned({}, {}, {}, true);
  learned.settle();
  for (RawBlack* black : {&processed, &learned}) {
    CHECK_FALSE(black->adopt(kBlack));
    CHECK_FALSE(black->stated());
  }
}

}  // namespace
}  // namespace hdrcam
