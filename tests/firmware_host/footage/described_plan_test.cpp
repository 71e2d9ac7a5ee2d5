// What import says of footage before it is a recording.
#include "firmware_host/footage/described_plan.h"

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

TEST_CASE("frames that come twice are warned of where they are many") {
  FootagePlan plan;
  plan.facts.resize(96);
  plan.copies = 12;  // as losses of two frames make them, too
  CHECK(describe_copies(plan).empty());
  plan.facts.resize(9);
  plan.copies = 2;
  CHECK(describe_copies(plan).empty());
  plan.facts.resize(96);
  plan.copies = 48;
  CHECK_THAT(describe_copies(plan), Catch::StartsWith("48 of 96 frames look as the one before them") &&
                                        Catch::Contains("ffmpeg -vf mpdecimate -fps_mode vfr"));
}

}  // namespace
}  // namespace hdrcam
