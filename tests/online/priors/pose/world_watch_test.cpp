// When a tracked camera is in another world.
#include "online/priors/pose/world_watch.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

CameraPose tracked(bool lost = false) {
  CameraPose pose;
  pose.lost = lost;
  return pose;
}

WorldWatch after_loss(int frames) {
  WorldWatch watch;
  watch.begin();
  for (int i = 0; i < frames; ++i) REQUIRE_FALSE(watch.ends_before(tracked(true)));
  return watch;
}

}  // namespace

TEST_CASE("a short loss is bridged, and behind a long one another world begins, once") {
  for (const int frames : {0, 1, 15}) {
    CAPTURE(frames);
    WorldWatch watch = after_loss(frames);
    CHECK_FALSE(watch.ends_before(tracked()));
  }
  WorldWatch watch = after_loss(16);
  CHECK(watch.ends_before(tracked()));
  CHECK_FALSE(watch.ends_before(tracked()));
}
