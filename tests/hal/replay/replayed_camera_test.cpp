#include "hal/replay/replayed_camera.h"

#include <chrono>
#include <cmath>

#include "hal/pixel_pack.h"
#include "hal/recording/recording.h"
#include "hal/sim/virtual_clock.h"
#include "tests/contracts/camera_contract.h"
#include "tests/contracts/expect.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/support/files.h"

using namespace hdrcam;
using std::chrono::milliseconds;

namespace {

constexpr int kFrames = 100;

RawFrame frame_of(const CameraFacts& camera, int i) {
  std::mt19937 random(static_cast<unsigned>(i));
  RawFrame frame{{}, sample::picture(camera, random)};
  frame.facts.sequence = static_cast<std::uint64_t>(i);
  frame.facts.exposure_s = i % 2 == 0 ? 0.001 : 0.008;
  frame.facts.analogue_gain = 1 + i % 3;
  frame.facts.readout_s = 0.0005;
  frame.facts.timestamp =
      Instant::from_seconds(5 + 0.01 * i + (frame.facts.exposure_s + frame.facts.readout_s) / 2);
  frame.facts.exposure_source = ExposureSource::Embedded;
  if (i % 5 == 0) frame.facts.flags = kFrameTriggerLate;
  return frame;
}

std::string write_recording(const std::string& name, PixelLayout layout, int bits) {
  const CameraFacts camera = sample::camera(layout, bits, 32, 16);
  const std::string path = sample::scratch_folder(name) + "/r.mkv";
  auto writer = value_of(create_recording(posix_storage(), path, camera));
  for (int i = 0; i < kFrames; ++i) require_done(writer->append(frame_of(camera, i)));
  require_done(writer->finish());
  return path;
}

}  // namespace

TEST_CASE("the replayed camera keeps the camera contract") {
  const std::string path = write_recording("replay_contract", PixelLayout::Rgb, 8);
  keeps_camera_contract(
      {.name = "replayed",
       .open =
           [&] {
             return open_replayed_camera(posix_storage(), path, ReplayPace::AsFastAsAsked, posix_clock());
           },
       .mode = {PixelFormat::Rgb24, 32, 16, milliseconds(33)},
       .allocations_per_frame = 40});  // the reader's: decoding FFV1 and JSON makes a fresh frame each time
}

TEST_CASE("a replay hands over the pixels and facts that were recorded") {
  for (const auto& [layout, bits] : {std::pair{PixelLayout::Rgb, 8}, {PixelLayout::BayerGrbg, 12}}) {
    const std::string path = write_recording("replay_pixels", layout, bits);
    auto camera =
        value_of(open_replayed_camera(posix_storage(), path, ReplayPace::AsFastAsAsked, posix_clock()));
    const StreamMode mode = value_of(camera->configure(camera->capabilities().modes.front(), 3));
    require_done(camera->start());
    const CameraFacts facts = sample::camera(layout, bits, 32, 16);
    for (int i = 0; i < kFrames; ++i) {
      require_done(camera->queue({static_cast<std::uint64_t>(7 + i), milliseconds(1), 1}));
      const CapturedBuffer buffer = value_of(camera->wait(std::chrono::seconds(2)));
      const RawFrame truth = frame_of(facts, i);
      std::vector<std::byte> expected(packed_stride(mode.format, 32) * 16);
      pack_codes(truth.codes, mode.format, expected);
      REQUIRE(std::equal(expected.begin(), expected.end(), buffer.pixels.begin(), buffer.pixels.end()));
      REQUIRE(buffer.cookie == static_cast<std::uint64_t>(7 + i));
      REQUIRE(buffer.sequence == truth.facts.sequence);
      REQUIRE(buffer.exposure == from_seconds(truth.facts.exposure_s));
      REQUIRE(buffer.analogue_gain == truth.facts.analogue_gain);
      REQUIRE(buffer.readout == std::chrono::microseconds(500));
      REQUIRE(buffer.centre == truth.facts.timestamp);
      REQUIRE(buffer.trigger_late == (i % 5 == 0));
      REQUIRE(buffer.exposure_source == ExposureSource::Embedded);
      REQUIRE(std::abs((buffer.timestamp - Instant::from_seconds(5 + 0.01 * i)).count()) <= 1);
    }
    require_done(camera->queue({0, milliseconds(1), 1}));
    const auto end = camera->wait(std::chrono::seconds(2));
    require_error(end, ErrorCode::Unplugged);
    CHECK(end.error().message.find("100 frames") != std::string::npos);
  }
}

TEST_CASE("a replay stamps the ends of exposures where those are a frame apart") {
  const CameraFacts facts = sample::camera(PixelLayout::Rgb, 8, 32, 16);
  const std::string path = sample::scratch_folder("replay_ends") + "/r.mkv";
  std::vector<RawFrame> frames;
  for (int i = 0; i < 8; ++i) {
    frames.push_back(frame_of(facts, i));
    FrameFacts& of = frames.back().facts;
    of.timestamp = Instant::from_seconds(5 + 0.01 * i - (of.exposure_s + of.readout_s) / 2);
  }
  require_done(sample::record(posix_storage(), path, facts, frames));
  auto camera =
      value_of(open_replayed_camera(posix_storage(), path, ReplayPace::AsFastAsAsked, posix_clock()));
  CHECK(camera->capabilities().timestamp_mark == TimestampMark::ExposureEnd);
  value_of(camera->configure(camera->capabilities().modes.front(), 2));
  require_done(camera->start());
  for (int i = 0; i < 8; ++i) {
    require_done(camera->queue({0, milliseconds(1), 1}));
    const CapturedBuffer buffer = value_of(camera->wait(std::chrono::seconds(2)));
    CHECK(std::abs((buffer.timestamp - Instant::from_seconds(5 + 0.01 * i)).count()) <= 1);
  }
  const std::string begins = write_recording("replay_begins", PixelLayout::Rgb, 8);
  camera = value_of(open_replayed_camera(posix_storage(), begins, ReplayPace::AsFastAsAsked, posix_clock()));
  CHECK(camera->capabilities().timestamp_mark == TimestampMark::ExposureBegin);
}

TEST_CASE("a replayed camera states the first black level that one of its frames states") {
  const CameraFacts facts = sample::camera(PixelLayout::BayerGrbg, 12, 32, 16);
  const std::string path = sample::scratch_folder("replay_black") + "/r.mkv";
  std::vector<RawFrame> frames;
  for (int i = 0; i < 4; ++i) {
    frames.push_back(frame_of(facts, i));
    if (i > 0) frames.back().facts.black_level = BlackLevel::of_code(i == 1 ? 256 : 300, facts.bits);
  }
  require_done(sample::record(posix_storage(), path, facts, frames));
  const auto camera =
      value_of(open_replayed_camera(posix_storage(), path, ReplayPace::AsFastAsAsked, posix_clock()));
  CHECK(sample::same_black_level(camera->capabilities().black_level, BlackLevel::of_code(256, facts.bits)));
}

TEST_CASE("a replay that is configured with fewer buffers completes its requests in order from the first") {
  const std::string path = write_recording("replay_again", PixelLayout::Rgb, 8);
  auto camera =
      value_of(open_replayed_camera(posix_storage(), path, ReplayPace::AsFastAsAsked, posix_clock()));
  for (const int buffers : {7, 2}) {
    value_of(camera->configure(camera->capabilities().modes.front(), buffers));
    require_done(camera->start());
    for (std::uint64_t i = 0; i < 5; ++i) {
      require_done(camera->queue({100 + i, milliseconds(1), 1}));
      CHECK(value_of(camera->wait(std::chrono::seconds(2))).cookie == 100 + i);
    }
    require_done(camera->stop());
  }
}

TEST_CASE("a paced replay takes as long as the recording did") {
  const std::string path = write_recording("replay_pace", PixelLayout::Rgb, 8);
  auto camera = value_of(open_replayed_camera(posix_storage(), path, ReplayPace::AsRecorded, posix_clock()));
  value_of(camera->configure(camera->capabilities().modes.front(), 2));
  require_done(camera->start());
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < 21; ++i) {
    require_done(camera->queue({0, milliseconds(1), 1}));
    value_of(camera->wait(std::chrono::seconds(2)));
  }
  CHECK(std::chrono::steady_clock::now() - begin >= milliseconds(199));
}

TEST_CASE("a pause of a recording is cut in its paced replay, and the instants of the frames stay") {
  constexpr Duration kPause = std::chrono::hours(1);
  const CameraFacts facts = sample::camera(PixelLayout::Rgb, 8, 32, 16);
  const std::string path = sample::scratch_folder("replay_pause") + "/r.mkv";
  std::vector<RawFrame> frames;
  for (int i = 0; i < 4; ++i) {
    frames.push_back(frame_of(facts, i));
    if (i >= 2) frames.back().facts.timestamp = frames.back().facts.timestamp + kPause;
  }
  require_done(sample::record(posix_storage(), path, facts, frames));
  auto camera = value_of(open_replayed_camera(posix_storage(), path, ReplayPace::AsRecorded, posix_clock()));
  value_of(camera->configure(camera->capabilities().modes.front(), 2));
  require_done(camera->start());
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < 4; ++i) {
    require_done(camera->queue({0, milliseconds(1), 1}));
    const CapturedBuffer buffer = value_of(camera->wait(std::chrono::seconds(2)));
    const Instant recorded = Instant::from_seconds(5 + 0.01 * i) + (i >= 2 ? kPause : Duration::zero());
    CHECK(std::abs((buffer.timestamp - recorded).count()) <= 1);
  }
  CHECK(std::chrono::steady_clock::now() - begin >= std::chrono::seconds(1));
}

TEST_CASE("a recording of a slow camera has no pauses, and its paced replay is as slow") {
  CameraFacts facts = sample::camera(PixelLayout::Rgb, 8, 32, 16);
  facts.framerate_hz = 0.5;
  const std::string path = sample::scratch_folder("replay_slow") + "/r.mkv";
  std::vector<RawFrame> frames;
  for (int i = 0; i < 2; ++i) {
    frames.push_back(frame_of(facts, i));
    frames.back().facts.timestamp = Instant::from_seconds(5 + 2 * i);
  }
  require_done(sample::record(posix_storage(), path, facts, frames));
  auto camera = value_of(open_replayed_camera(posix_storage(), path, ReplayPace::AsRecorded, posix_clock()));
  value_of(camera->configure(camera->capabilities().modes.front(), 2));
  require_done(camera->start());
  for (int i = 0; i < 2; ++i) require_done(camera->queue({0, milliseconds(1), 1}));
  value_of(camera->wait(std::chrono::seconds(2)));
  require_error(camera->wait(Duration::zero()), ErrorCode::Timeout);  // the next is 2 s away
  require_error(camera->wait(milliseconds(1200)), ErrorCode::Timeout);
}

TEST_CASE("frames of unknown exposure are replayed without one, and are in no cycle") {
  const CameraFacts facts = sample::camera(PixelLayout::Rgb, 8, 32, 16);
  const std::string path = sample::scratch_folder("replay_unknown") + "/r.mkv";
  std::vector<RawFrame> frames;
  for (int i = 0; i < 8; ++i) {
    frames.push_back(frame_of(facts, i));
    frames.back().facts.analogue_gain = 1;
    if (i >= 6) frames.back().facts.exposure_s = std::nan("");
  }
  require_done(sample::record(posix_storage(), path, facts, frames));
  auto camera =
      value_of(open_replayed_camera(posix_storage(), path, ReplayPace::AsFastAsAsked, posix_clock()));
  const auto& cycle = camera->capabilities().cycle;
  REQUIRE(cycle.size() == 2);
  CHECK(cycle[0].exposure == milliseconds(1));
  CHECK(cycle[1].exposure == milliseconds(8));
  value_of(camera->configure(camera->capabilities().modes.front(), 2));
  require_done(camera->start());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    require_done(camera->queue({0, milliseconds(1), 1}));
    const CapturedBuffer buffer = value_of(camera->wait(std::chrono::seconds(2)));
    CHECK(buffer.exposure.has_value() == (i < 6));
    if (i >= 6) CHECK(buffer.timestamp == frames[i].facts.timestamp);
  }
}

TEST_CASE("a damaged frame is one that a replayed camera lost, and is named") {
  const std::string path = write_recording("replay_damaged", PixelLayout::Rgb, 8);
  const std::string bytes = read_whole(posix_storage(), path).value();
  for (const int damaged : {0, 3, 60}) {  // 0, 3: among those that open_replayed_camera() looks at
    CAPTURE(damaged);
    std::string flipped = bytes;
    flipped[flipped.find(fmt::format("{{\"index\":{},", damaged)) - 30] ^= 1;
    test::write_file(path, flipped);
    auto camera =
        value_of(open_replayed_camera(posix_storage(), path, ReplayPace::AsFastAsAsked, posix_clock()));
    value_of(camera->configure(camera->capabilities().modes.front(), 2));
    require_done(camera->start());
    for (int i = 0; i < kFrames; ++i) {
      if (i == damaged) continue;
      require_done(camera->queue({0, milliseconds(1), 1}));
      REQUIRE(value_of(camera->wait(std::chrono::seconds(2))).sequence == static_cast<std::uint64_t>(i));
    }
    require_done(camera->queue({0, milliseconds(1), 1}));
    require_error(camera->wait(std::chrono::seconds(2)), ErrorCode::Unplugged);
    const std::vector<std::string> warnings = camera->warnings();
    REQUIRE(warnings.size() == 1);
    CHECK(warnings.front().starts_with(fmt::format("1 damaged frame left out: {} (", damaged)));
  }
}

TEST_CASE("a recording without a whole frame plays no camera") {
  const std::string path = write_recording("replay_no_frame", PixelLayout::Rgb, 8);
  std::string bytes = read_whole(posix_storage(), path).value();
  for (int i = 0; i < kFrames; ++i) bytes[bytes.find(fmt::format("{{\"index\":{},", i)) - 30] ^= 1;
  test::write_file(path, bytes);
  const auto camera = open_replayed_camera(posix_storage(), path, ReplayPace::AsRecorded, posix_clock());
  require_error(camera, ErrorCode::Corrupt);
  CHECK(camera.error().message.ends_with("has no whole frame"));
}

TEST_CASE("what cannot be replayed is refused in a sentence") {
  const std::string path = write_recording("replay_refused", PixelLayout::Rgb, 12);
  const auto deep = open_replayed_camera(posix_storage(), path, ReplayPace::AsRecorded, posix_clock());
  require_error(deep, ErrorCode::Unsupported);  // which every verb reads that takes a recording for a camera
  CHECK(deep.error().message.ends_with("no pixel format of a camera; read it without --pace realtime"));
  require_error(open_replayed_camera(posix_storage(), path + "x", ReplayPace::AsRecorded, posix_clock()),
                ErrorCode::NotFound);
}
