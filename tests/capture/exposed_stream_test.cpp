#include "capture/exposed_stream.h"

#include <cmath>

#include "tests/support/moving_scene.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

struct Handed {
  std::vector<ExposedFrame> frames;
  ExposedStream::HandOn keep() {
    return [this](ExposedFrame& frame) -> Result<void> {
      frames.push_back(std::exchange(frame, {}));
      return {};
    };
  }
};

}  // namespace

TEST_CASE("the first frames of a stream wait for their cycle, then each is handed on as it arrives") {
  test::MovingScene scene;
  scene.exposures_s = {0.001, 0.004, 0.032};
  ExposedStream stream(scene.camera(), 6, StatedBlack::Kept);
  Handed handed;
  for (int i = 0; i < 9; ++i) {
    REQUIRE(stream.take(scene.frame(i), handed.keep()).ok());
    CHECK(handed.frames.size() == static_cast<std::size_t>(i < 5 ? 0 : i + 1));
  }
  REQUIRE(stream.finish(handed.keep()).ok());
  REQUIRE(handed.frames.size() == 9);
  const double reference_s = std::cbrt(0.001 * 0.004 * 0.032);
  for (std::size_t i = 0; i < 9; ++i) {
    const ExposedFrame& frame = handed.frames[i];
    CHECK(frame.index == static_cast<int>(i));
    CHECK(frame.reference_exposure == Approx(reference_s));
    CHECK(frame.exposure == Approx(scene.exposures_s[i % 3] / reference_s));
    CHECK(frame.codes.channels() == 3);
  }
}

TEST_CASE("a frame is blurred for as long as it was exposed, and not at all where only the ratio is known") {
  test::MovingScene scene;
  scene.exposures_s = {0.001, 0.004, 0.016};
  for (const ExposureSource source : {ExposureSource::Declared, ExposureSource::Estimated}) {
    ExposedStream stream(scene.camera(), 3, StatedBlack::Kept);
    Handed handed;
    for (int i = 0; i < 6; ++i) {
      RawFrame frame = scene.frame(i);
      frame.facts.exposure_source = source;
      REQUIRE(stream.take(frame, handed.keep()).ok());
    }
    for (std::size_t i = 0; i < 6; ++i) {
      const double expected =
          source == ExposureSource::Declared ? scene.exposures_s[i % 3] * scene.framerate_hz : 0;
      CHECK(handed.frames[i].blur_fraction == Approx(expected));
    }
  }
}

TEST_CASE("a short stream is handed on at its end, and one frame is too few") {
  const test::MovingScene scene;
  for (const int frames : {1, 2, 5}) {
    ExposedStream stream(scene.camera(), 6, StatedBlack::Kept);
    Handed handed;
    for (int i = 0; i < frames; ++i) REQUIRE(stream.take(scene.frame(i), handed.keep()).ok());
    CHECK(handed.frames.empty());
    const Result<void> finished = stream.finish(handed.keep());
    CHECK(finished.ok() == (frames > 1));
    if (!finished) CHECK(finished.error().code == ErrorCode::TooShort);
    CHECK(handed.frames.size() == static_cast<std::size_t>(frames > 1 ? frames : 0));
  }
}

TEST_CASE("a stated black level is removed, or kept for whoever estimates the response") {
  const test::MovingScene scene;
  const auto first_of = [&](StatedBlack stated) {
    ExposedStream stream(scene.camera(), 2, stated);
    Handed handed;
    for (int i = 0; i < 2; ++i) {
      RawFrame frame = scene.frame(i);
      frame.facts.black_level = BlackLevel(24);
      REQUIRE(stream.take(frame, handed.keep()).ok());
    }
    return std::move(handed.frames.front());
  };
  const ExposedFrame kept = first_of(StatedBlack::Kept), removed = first_of(StatedBlack::Removed);
  const auto before = kept.codes.samples(), after = removed.codes.samples();
  for (std::size_t i = 0; i < before.size(); ++i)
    REQUIRE(after[i] == Approx(std::max(0.f, (before[i] - 24) * 255 / (255 - 24))).margin(1e-3));
}

TEST_CASE("an exposure that cannot be is an error when its frame arrives, even while frames wait") {
  test::MovingScene scene;
  scene.exposures_s = {0.001, std::nan("")};
  scene.full_well = 0;
  ExposedStream stream(scene.camera(), 6, StatedBlack::Kept);
  Handed handed;
  REQUIRE(stream.take(scene.frame(0), handed.keep()).ok());
  const Result<void> taken = stream.take(scene.frame(1), handed.keep());
  REQUIRE_FALSE(taken.ok());
  CHECK(taken.error().code == ErrorCode::BadExposure);
}
