#include "capture/exposed_stream.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "tests/support/moving_scene.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using namespace std::chrono_literals;

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

double reference_of(const test::MovingScene& scene, const std::vector<RawFrame>& frames) {
  ExposedStream stream(scene.camera(), static_cast<int>(frames.size()), StatedBlack::Kept);
  Handed handed;
  for (const RawFrame& frame : frames) REQUIRE(stream.take(frame, handed.keep()).ok());
  REQUIRE(handed.frames.size() == frames.size());
  return handed.frames.front().reference_exposure;
}

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

TEST_CASE("codes of a linear camera become their roots, whose dark ones are told apart") {
  for (const bool linear : {true, false}) {
    constexpr int kBits = 12;
    CameraFacts camera;
    camera.width = 4, camera.height = 2, camera.bits = kBits, camera.linear = linear;
    ExposedStream stream(camera, 2, StatedBlack::Removed);
    Handed handed;
    const std::uint16_t most = static_cast<std::uint16_t>((1 << kBits) - 1);
    const std::array<std::uint16_t, 4> codes{1, 16, 100, most};
    for (int i = 0; i < 2; ++i) {
      RawFrame raw;
      raw.facts.sequence = i, raw.facts.timestamp = Instant{i * 33ms};
      raw.facts.exposure_s = i == 0 ? 0.001 : 0.004;
      raw.codes = Image<std::uint16_t>(3, 2, 4);
      for (int c = 0; c < 3; ++c)
        for (int y = 0; y < 2; ++y) std::ranges::copy(codes, raw.codes.row(c, y));
      REQUIRE(stream.take(raw, handed.keep()).ok());
    }
    REQUIRE(handed.frames.size() == 2);
    for (std::size_t x = 0; x < codes.size(); ++x) {
      const float share = static_cast<float>(codes[x]) / static_cast<float>(most);
      INFO("linear " << linear << ", code " << codes[x]);
      CHECK(handed.frames[0].codes.at(1, 0, static_cast<int>(x)) ==
            Approx(255 * (linear ? std::sqrt(share) : share)));
    }
  }
}

TEST_CASE("a frame is blurred for as long as it was exposed, and not at all where only the ratio is known") {
  test::MovingScene scene;
  const std::vector<std::vector<double>> cycles{{0.001, 0.004, 0.016}, {0.03, 0.001}};
  for (const auto& cycle : cycles)
    for (const ExposureSource source : {ExposureSource::Declared, ExposureSource::Estimated}) {
      scene.exposures_s = cycle;
      ExposedStream stream(scene.camera(), 3, StatedBlack::Kept);
      Handed handed;
      for (int i = 0; i < 6; ++i) {
        RawFrame frame = scene.frame(i);
        frame.facts.exposure_source = source;
        frame.facts.timestamp = frame.facts.timestamp + from_seconds(frame.facts.exposure_s / 2);  // centre
        REQUIRE(stream.take(frame, handed.keep()).ok());
      }
      for (std::size_t i = 0; i < 6; ++i) {
        const double exposure_s = cycle[i % cycle.size()];
        double interval_s = 1 / scene.framerate_hz;  // no frame precedes the first one
        if (i > 0) interval_s += (exposure_s - cycle[(i - 1) % cycle.size()]) / 2;
        const double expected = source == ExposureSource::Declared ? exposure_s / interval_s : 0;
        CAPTURE(cycle, i);
        CHECK(handed.frames[i].blur_fraction == Approx(expected));
      }
    }
}

TEST_CASE("a long exposure that ends a frame after a short one is blurred, though their centres are nearer") {
  test::MovingScene scene;
  const double frame_s = 1 / scene.framerate_hz;
  scene.exposures_s = {0.001, 0.004, 0.028};
  for (const double stated_hz : {30.0, 60.0}) {  // of 60 the long exposure outlasts each frame
    CameraFacts camera = scene.camera();
    camera.framerate_hz = stated_hz;
    ExposedStream stream(camera, 3, StatedBlack::Kept);
    Handed handed;
    for (int i = 0; i < 9; ++i) {
      RawFrame frame = scene.frame(i);
      frame.facts.exposure_source = ExposureSource::Declared;
      frame.facts.timestamp = frame.facts.timestamp + from_seconds(frame_s - frame.facts.exposure_s / 2);
      REQUIRE(stream.take(frame, handed.keep()).ok());
    }
    for (std::size_t i = 1; i < 9; ++i) {
      const double exposure_s = scene.exposures_s[i % 3],
                   interval_s = frame_s - (exposure_s - scene.exposures_s[(i - 1) % 3]) / 2;
      const bool outlasts = stated_hz > 30 && i % 3 == 2;
      CAPTURE(stated_hz, i);
      CHECK(handed.frames[i].blur_fraction == Approx(outlasts ? 0 : exposure_s / interval_s));
    }
  }
}

TEST_CASE("the reference is that of the whole cycle, whichever of its first frames is lost") {
  test::MovingScene scene;
  for (const bool numbered : {true, false})
    for (int lost = 0; lost < 6; ++lost) {
      std::vector<RawFrame> frames;
      for (int i = 0; i < 7; ++i)
        if (i != lost) frames.push_back(scene.frame(i));
      for (std::size_t i = 0; i < frames.size() && !numbered; ++i) frames[i].facts.sequence = i;
      CAPTURE(numbered, lost);
      CHECK(reference_of(scene, frames) == Approx(0.004));
    }
}

TEST_CASE("frames from before the first control acted do not count for the reference") {
  test::MovingScene scene;
  scene.exposures_s = {0.004, 0.004, 0.0001, 0.0004, 0.0016, 0.0001};
  std::vector<RawFrame> frames;
  for (int i = 0; i < 6; ++i) {
    frames.push_back(scene.frame(i));
    frames.back().facts.slot = i < 2 ? -1 : (i - 2) % 3;
  }
  CHECK(reference_of(scene, frames) == Approx(0.0004));
  frames.erase(frames.begin() + 3);  // a slot that no frame has
  CHECK(reference_of(scene, frames) == Approx(0.0004));
}

TEST_CASE("exposures that jitter count once for each slot, by its first frame") {
  test::MovingScene scene;
  scene.exposures_s = {0.001, 0.0042, 0.016, 0.0013, 0.0039, 0.015};
  std::vector<RawFrame> frames;
  for (int i = 0; i < 6; ++i) frames.push_back(scene.frame(i));
  CHECK(reference_of(scene, frames) == Approx(std::cbrt(0.001 * 0.0042 * 0.016)));
  scene.exposures_s = {0.001, 0.0013};  // two exposures, and no jitter
  for (int i = 0; i < 6; ++i) frames[static_cast<std::size_t>(i)] = scene.frame(i);
  CHECK(reference_of(scene, frames) == Approx(std::sqrt(0.001 * 0.0013)));
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

TEST_CASE(
    "each frame loses its own black level, which may go by its gain; one that states none the first's") {
  const test::MovingScene scene;
  const auto handed_by = [&](StatedBlack stated) {
    ExposedStream stream(scene.camera(), 3, stated);
    Handed handed;
    for (int i = 0; i < 4; ++i) {
      RawFrame frame = scene.frame(i);
      if (i != 2) frame.facts.black_level = BlackLevel(i % 2 == 0 ? 24 : 40);
      REQUIRE(stream.take(frame, handed.keep()).ok());
    }
    REQUIRE(handed.frames.size() == 4);
    return handed;
  };
  const Handed kept = handed_by(StatedBlack::Kept), removed = handed_by(StatedBlack::Removed);
  for (std::size_t i = 0; i < 4; ++i) {
    const float black = i % 2 == 0 ? 24 : 40;
    const auto before = kept.frames[i].codes.samples(), after = removed.frames[i].codes.samples();
    CAPTURE(i);
    for (std::size_t k = 0; k < before.size(); ++k)
      REQUIRE(after[k] == Approx(std::max(0.f, (before[k] - black) * 255 / (255 - black))).margin(1e-3));
  }
}

TEST_CASE("where the first frame states no black level, those that state one lose theirs all the same") {
  const test::MovingScene scene;
  constexpr int kBlack = 24, kWaiting = 3;
  const auto handed_by = [&](StatedBlack stated_black, int stating) {
    ExposedStream stream(scene.camera(), kWaiting, stated_black);
    Handed handed;
    for (int i = 0; i < 6; ++i) {
      RawFrame frame = scene.frame(i);
      if (i == stating) frame.facts.black_level = BlackLevel(kBlack);
      REQUIRE(stream.take(frame, handed.keep()).ok());
    }
    REQUIRE(handed.frames.size() == 6);
    return handed;
  };
  const Handed kept = handed_by(StatedBlack::Kept, kWaiting - 1);
  for (const int stating : {kWaiting - 1, kWaiting + 1}) {  // among those that wait, and behind them
    const Handed removed = handed_by(StatedBlack::Removed, stating);
    for (int i = 0; i < 6; ++i) {
      const bool of_all = stating < kWaiting, loses = of_all || i == stating;
      const float black = loses ? float{kBlack} : 0.f;
      const ExposedFrame &before = kept.frames[static_cast<std::size_t>(i)],
                         &after = removed.frames[static_cast<std::size_t>(i)];
      CAPTURE(stating, i);
      for (std::size_t k = 0; k < before.codes.samples().size(); ++k)
        REQUIRE(
            after.codes.samples()[k] ==
            Approx(std::max(0.f, (before.codes.samples()[k] - black) * 255 / (255 - black))).margin(1e-3));
      CHECK(after.exposure == Approx(before.exposure * (loses && !of_all ? 255. / (255 - kBlack) : 1)));
      CHECK(after.facts.black_level.has_value() == loses);
    }
  }
}

TEST_CASE("light has one scale in all frames, whatever black level each of them states") {
  constexpr std::uint16_t kAboveBlack = 60;  // codes of 1 ms; the same light in all frames
  for (const bool linear : {true, false}) {
    CameraFacts camera;
    camera.width = 4, camera.height = 2, camera.linear = linear;
    ExposedStream stream(camera, 2, StatedBlack::Removed);
    Handed handed;
    for (int i = 0; i < 4; ++i) {
      const int black = i < 3 ? 16 * i : 64;
      const std::uint16_t times = i % 2 == 0 ? 1 : 2;
      RawFrame raw;
      raw.facts.sequence = static_cast<std::uint64_t>(i), raw.facts.timestamp = Instant{i * 33ms};
      raw.facts.exposure_s = 0.001 * times;
      raw.facts.black_level = BlackLevel(black);
      raw.codes = Image<std::uint16_t>(3, 2, 4);
      raw.codes.fill(static_cast<std::uint16_t>(black + times * kAboveBlack));
      REQUIRE(stream.take(raw, handed.keep()).ok());
    }
    REQUIRE(handed.frames.size() == 4);
    const auto light_of = [&](const ExposedFrame& frame) {
      const float share = frame.codes.at(1, 0, 0) / kMaxCode;
      return (linear ? share * share : share) / frame.exposure;
    };
    for (const ExposedFrame& frame : handed.frames) {
      INFO("linear " << linear << ", frame " << frame.index);
      CHECK(light_of(frame) == Approx(light_of(handed.frames.front())));
    }
  }
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

TEST_CASE("codes of which white is not the largest are stretched, where the response is unknown") {
  test::MovingScene scene;
  scene.sensitivity = 15;  // nothing is too bright
  for (const StatedBlack stated : {StatedBlack::Kept, StatedBlack::Removed}) {
    ExposedStream stream(scene.camera(), 6, stated);
    Handed handed;
    for (int i = 0; i < 7; ++i) {
      RawFrame frame = scene.frame(i);
      for (std::uint16_t& code : frame.codes.samples()) code = std::min<std::uint16_t>(code, 180);
      for (int c = 0; c < 3; ++c)  // the first lines are white, more of them in longer exposures
        std::fill_n(frame.codes.plane(c), 3 * (1 + i % 3) * frame.codes.cols(), 200);
      REQUIRE(stream.take(frame, handed.keep()).ok());
    }
    const bool stretched = stated == StatedBlack::Kept;
    for (const ExposedFrame& frame : handed.frames) {
      CHECK(frame.white.is_largest_code() == !stretched);
      CHECK(frame.codes.at(1, 0, 0) == Approx(stretched ? 255 : 200));
      CHECK(*std::ranges::max_element(frame.codes.samples()) <= kMaxCode);
    }
  }
}
