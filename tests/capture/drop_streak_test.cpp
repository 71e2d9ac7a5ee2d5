#include "capture/drop_streak.h"

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

const std::string kCamera = "cam";

TEST_CASE("a good frame ends a row of damaged ones, and thirty in a row are too many", "[capture]") {
  DropStreak streak;
  for (int i = 0; i < 29; ++i) REQUIRE(streak.damaged(kCamera).ok());
  streak.end();
  for (int i = 0; i < 29; ++i) REQUIRE(streak.damaged(kCamera).ok());
  const Result<void> last = streak.damaged(kCamera);
  REQUIRE_FALSE(last.ok());
  CHECK(last.error().code == ErrorCode::Corrupt);
  CHECK(last.error().message.find("30 frames of 'cam' in a row were damaged") == 0);
}

TEST_CASE("the first reason in a row is named, and a reason of the format ends it at once", "[capture]") {
  DropStreak streak;
  REQUIRE(streak.not_decoded(kCamera, {ErrorCode::Corrupt, "the first"}).ok());
  streak.end();
  REQUIRE(streak.not_decoded(kCamera, {ErrorCode::Corrupt, "the second"}).ok());
  for (int i = 0; i < 28; ++i) REQUIRE(streak.damaged(kCamera).ok());
  const Result<void> last = streak.not_decoded(kCamera, {ErrorCode::Corrupt, "the last"});
  REQUIRE_FALSE(last.ok());
  CHECK(last.error().message.find("for this reason: the second;") != std::string::npos);

  streak.end();
  const Result<void> format = streak.not_decoded(kCamera, {ErrorCode::Unsupported, "no such format"});
  REQUIRE_FALSE(format.ok());
  CHECK(format.error().code == ErrorCode::Unsupported);
}

}  // namespace
}  // namespace hdrcam
