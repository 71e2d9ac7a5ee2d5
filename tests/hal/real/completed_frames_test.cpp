#include "hal/real/completed_frames.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using namespace std::chrono_literals;

namespace {

constexpr Duration kInterval = 30ms;

Instant at(Duration since_boot) { return {since_boot}; }

}  // namespace

TEST_CASE("a cancelled request counts as the next frame, whatever its buffer held before") {
  CompletedFrames frames;
  frames.completed(40, at(1000ms));
  const auto cancelled = frames.cancelled(at(1075ms), kInterval);
  CHECK(cancelled.sequence == 41);
  CHECK(cancelled.timestamp == at(1030ms));
  const auto another = frames.cancelled(at(1080ms), kInterval);
  CHECK(another.sequence == 42);
  CHECK(another.timestamp == at(1060ms));
  const auto next = frames.completed(43, at(1090ms));
  CHECK(next.sequence == 43);
  CHECK(next.timestamp == at(1090ms));
}

TEST_CASE("requests that are cancelled at once have no time that is still to come") {
  CompletedFrames frames;
  frames.completed(40, at(1000ms));
  for (int i = 0; i < 4; ++i) CHECK(frames.cancelled(at(1050ms), kInterval).timestamp <= at(1050ms));
}

TEST_CASE("a stream whose first request is cancelled begins then, also after a restart") {
  CompletedFrames frames;
  CHECK(frames.cancelled(at(500ms), kInterval).timestamp == at(500ms));
  frames.completed(40, at(1000ms));
  frames.restart();
  const auto first = frames.cancelled(at(2000ms), kInterval);
  CHECK(first.sequence == 0);
  CHECK(first.timestamp == at(2000ms));
}
