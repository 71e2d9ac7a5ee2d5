#include "hal/recording/recording.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <new>
#include <utility>

#include "hal/fault/faulty_storage.h"
#include "tests/hal/recording/sample_recordings.h"

#include "tests/support/files.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;

TEST_CASE("a recording gives back every bit of every frame, in every codec, layout and depth") {
  const std::string folder = sample::scratch_folder("roundtrip");
  for (const auto layout :
       {PixelLayout::Rgb, PixelLayout::Mono, PixelLayout::BayerRggb, PixelLayout::BayerBggr})
    for (const int bits : {8, 9, 10, 11, 12, 13, 14, 15, 16})
      for (const auto& [width, height] : {std::pair{37, 23}, {2, 2}, {2, 65}, {130, 97}}) {
        INFO(name(layout) << ' ' << bits << " bits " << width << 'x' << height);
        const CameraFacts camera = sample::camera(layout, bits, width, height);
        auto frames = sample::frames(camera, 3, 7);
        frames[1].codes.fill(frames[1].codes.samples()[0]);  // flat: codes run lengths instead
        std::sort(frames[2].codes.samples().begin(), frames[2].codes.samples().end());  // smooth
        const std::string path = folder + "/x.mkv";
        for (const RecordingCodec codec : sample::kCodecs) {
          INFO(name(codec));
          const auto recorded = sample::record(posix_storage(), path, camera, frames, codec);
          INFO(recorded.error().message);
          REQUIRE(recorded.ok());
          CHECK(value_of(open_recording(posix_storage(), path))->codec() == codec);
          const auto replayed = sample::replay(posix_storage(), path);
          INFO((replayed.error ? replayed.error->message : ""));
          REQUIRE(!replayed.error);
          REQUIRE(replayed.frames.size() == 3);
          REQUIRE(replayed.is_start_of(frames));
        }
      }
}

TEST_CASE("a recording whose stated response falls or is not finite is refused by its channel and code") {
  const std::string path = sample::scratch_folder("falling") + "/x.mkv";
  for (const double value : {0.001, std::numeric_limits<double>::quiet_NaN()}) {
    CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, 32, 24);
    camera.response.assign(3, std::vector<double>(256));
    for (auto& curve : camera.response)
      for (std::size_t code = 0; code < 256; ++code) curve[code] = static_cast<double>(code) / 255;
    camera.response[2][9] = value;
    REQUIRE(sample::record(posix_storage(), path, camera, sample::frames(camera, 3, 1)).ok());
    const Error error = sample::error_of(open_recording(posix_storage(), path));
    INFO(error.message);
    CHECK(error.code == ErrorCode::Corrupt);
    for (const std::string word : {path.c_str(), "blue", "code 9"})
      CHECK(error.message.find(word) != std::string::npos);
  }
}

TEST_CASE("a recording gives back the camera facts and knows how many frames it has") {
  const std::string path = sample::scratch_folder("camera") + "/x.mkv";
  CameraFacts camera = sample::camera(PixelLayout::BayerGrbg, 10, 37, 23);
  camera.linear = true;
  camera.intrinsics = Intrinsics{100.1 + 0.2, 100 + 1.0 / 3.0, 18.5, 1e-300};
  camera.white_balance = ChannelGains{2.1, 1, 1.0 / 0.7};
  camera.turned_upright = true;
  camera.response.assign(3, std::vector<double>(256));
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t i = 0; i < 256; ++i) camera.response[c][i] = static_cast<double>(i * (c + 1)) / 765.1;
  const auto frames = sample::frames(camera, 40, 3);
  REQUIRE(sample::record(posix_storage(), path, camera, frames).ok());

  const auto reader = open_recording(posix_storage(), path);
  REQUIRE(reader.ok());
  const CameraFacts& read = reader.value()->camera();
  CHECK(read.name == camera.name);
  CHECK((read.width == 37 && read.height == 23 && read.bits == 10));
  CHECK(read.layout == PixelLayout::BayerGrbg);
  CHECK(read.linear);
  CHECK(sample::same_bits(read.framerate_hz, camera.framerate_hz));
  REQUIRE(read.intrinsics);
  CHECK(sample::same_bits(read.intrinsics->fx_px, camera.intrinsics->fx_px));
  CHECK(sample::same_bits(read.intrinsics->fy_px, camera.intrinsics->fy_px));
  CHECK(sample::same_bits(read.intrinsics->cx_px, 18.5));
  CHECK(sample::same_bits(read.intrinsics->cy_px, 1e-300));
  CHECK(read.response == camera.response);
  CHECK(read.white_balance == camera.white_balance);
  CHECK(read.turned_upright);
  CHECK(reader.value()->frame_count() == 40);
}

TEST_CASE("a recording without frames is complete and empty") {
  const std::string path = sample::scratch_folder("empty") + "/x.mkv";
  const auto writer = create_recording(posix_storage(), path, sample::camera(PixelLayout::Mono, 8, 8, 8));
  REQUIRE(writer.ok());
  REQUIRE(writer.value()->finish().ok());
  const auto replayed = sample::replay(posix_storage(), path);
  CHECK(!replayed.error);
  CHECK(replayed.frames.empty());
}

TEST_CASE("the same frames give the same bytes") {
  const std::string folder = sample::scratch_folder("bytes");
  for (const RecordingCodec codec : sample::kCodecs)
    for (const int bits : {8, 12}) {
      INFO(name(codec) << ' ' << bits << " bits");
      const CameraFacts camera = sample::camera(PixelLayout::Rgb, bits, 130, 97);
      const auto frames = sample::frames(camera, 5, 11);
      REQUIRE(sample::record(posix_storage(), folder + "/a.mkv", camera, frames, codec).ok());
      REQUIRE(sample::record(posix_storage(), folder + "/b.mkv", camera, frames, codec).ok());
      CHECK(test::text_of(folder + "/a.mkv") == test::text_of(folder + "/b.mkv"));
    }
}

TEST_CASE("frames within a millisecond have time stamps of their own, by which other programs order them") {
  const std::string path = sample::scratch_folder("within") + "/x.mkv";
  const CameraFacts camera = sample::camera(PixelLayout::Mono, 8, 8, 8);
  auto frames = sample::frames(camera, 6, 5);
  for (std::size_t i = 1; i < frames.size(); ++i)
    frames[i].facts.timestamp = frames[0].facts.timestamp +
                                (i < 5 ? std::chrono::microseconds(20 * i) : std::chrono::milliseconds(9));
  REQUIRE(sample::record(posix_storage(), path, camera, frames).ok());
  std::vector<int> times_ms;  // of the clusters: behind identifier, size (two bytes) and checksum
  const std::string bytes = test::text_of(path);
  for (std::size_t at = 0; (at = bytes.find("\x1f\x43\xb6\x75", at)) != std::string::npos; ++at)
    if (bytes.compare(at + 12, 2, "\xe7\x81") == 0)
      times_ms.push_back(static_cast<std::uint8_t>(bytes[at + 14]));
  REQUIRE(times_ms.size() >= frames.size());
  times_ms.resize(frames.size());
  CHECK(times_ms == std::vector<int>{0, 1, 2, 3, 4, 9});
}

TEST_CASE("players are told the interval of the nominal frame rate: 29.97 is 30000 / 1001") {
  const std::string path = sample::scratch_folder("players_rate") + "/x.mkv";
  CameraFacts camera = sample::camera(PixelLayout::Mono, 8, 8, 8);
  for (const auto& [hz, nominal_hz] :
       {std::pair(29.97, 30000 / 1001.0), {23.976, 24000 / 1001.0}, {59.94, 60000 / 1001.0}, {25.0, 25.0}}) {
    CAPTURE(hz);
    camera.framerate_hz = hz;
    require_done(sample::record(posix_storage(), path, camera, sample::frames(camera, 1, 5)));
    const std::string bytes = test::text_of(path);
    const std::size_t at = bytes.find("\x23\xe3\x83");  // DefaultDuration
    REQUIRE(at != std::string::npos);
    std::uint64_t interval_ns = 0;
    for (std::size_t i = 0, size = static_cast<std::uint8_t>(bytes[at + 3]) & 0x7fu; i < size; ++i)
      interval_ns = interval_ns << 8 | static_cast<std::uint8_t>(bytes[at + 4 + i]);
    CHECK(static_cast<double>(interval_ns) == Approx(1e9 / nominal_hz).epsilon(0).margin(1));
    CHECK(sample::same_bits(value_of(open_recording(posix_storage(), path))->camera().framerate_hz, hz));
  }
}

TEST_CASE("facts that are odd come back as they were") {
  const std::string path = sample::scratch_folder("odd") + "/x.mkv";
  const CameraFacts camera = sample::camera(PixelLayout::Mono, 8, 8, 8);
  auto frames = sample::frames(camera, 5, 5);
  frames[0].facts.exposure_s = -0.0;
  frames[1].facts.exposure_s = 5e-324;
  frames[1].facts.timestamp.since_boot = frames[0].facts.timestamp.since_boot + Duration(1);
  frames[2].facts.slot = -1;
  frames[3].facts.timestamp.since_boot = frames[2].facts.timestamp.since_boot + Duration(1);
  frames[3].facts.flags = ~0u;
  frames[4].facts.sequence = ~std::uint64_t{0};
  frames[4].facts.timestamp.since_boot += std::chrono::hours(24 * 40);  // a gap of weeks
  REQUIRE(sample::record(posix_storage(), path, camera, frames).ok());
  const auto replayed = sample::replay(posix_storage(), path);
  CHECK(replayed.frames.size() == 5);
  CHECK(replayed.is_start_of(frames));
}

TEST_CASE("an exposure that is not a number comes back as not a number") {
  const std::string path = sample::scratch_folder("nan") + "/x.mkv";
  const CameraFacts camera = sample::camera(PixelLayout::Mono, 8, 8, 8);
  auto frames = sample::frames(camera, 1, 5);
  frames[0].facts.exposure_s = std::nan("");
  REQUIRE(sample::record(posix_storage(), path, camera, frames).ok());
  const auto replayed = sample::replay(posix_storage(), path);
  REQUIRE(replayed.frames.size() == 1);
  CHECK(std::isnan(replayed.frames[0].facts.exposure_s));
}

TEST_CASE("next_facts lists a recording without its pixels") {
  const std::string path = sample::scratch_folder("facts") + "/x.mkv";
  const CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, 37, 23);
  const auto frames = sample::frames(camera, 6, 2);
  REQUIRE(sample::record(posix_storage(), path, camera, frames).ok());
  auto reader = open_recording(posix_storage(), path);
  REQUIRE(reader.ok());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (i == 3) {  // the two may be mixed
      const auto frame = reader.value()->next();
      REQUIRE((frame.ok() && frame.value()));
      CHECK(sample::same(*frame.value(), frames[i]));
      continue;
    }
    const auto facts = reader.value()->next_facts();
    REQUIRE((facts.ok() && facts.value()));
    CHECK(sample::same(*facts.value(), frames[i].facts));
  }
  const auto end = reader.value()->next_facts();
  REQUIRE(end.ok());
  CHECK(!end.value());
}

TEST_CASE("a frame takes the memory of one that is done with") {
  const std::string path = sample::scratch_folder("room") + "/x.mkv";
  const CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, 64, 48);
  const auto frames = sample::frames(camera, 3, 4);
  REQUIRE(sample::record(posix_storage(), path, camera, frames).ok());
  const auto reader = value_of(open_recording(posix_storage(), path));
  RawFrame small;
  small.codes = Image<std::uint16_t>(1, 3, 5);
  RawFrame frame = std::move(*value_of(reader->next(std::move(small))));
  CHECK(std::ranges::equal(frame.codes.samples(), frames[0].codes.samples()));
  const std::uint16_t* memory = frame.codes.plane(0);
  for (std::size_t i = 1; i < frames.size(); ++i) {
    frame = std::move(*value_of(reader->next(std::move(frame))));
    CHECK(frame.codes.plane(0) == memory);
    CHECK(std::ranges::equal(frame.codes.samples(), frames[i].codes.samples()));
    CHECK(frame.facts.sequence == frames[i].facts.sequence);
  }
}

TEST_CASE("a growing recording is readable up to the last appended frame") {
  const std::string path = sample::scratch_folder("live") + "/x.mkv";
  const CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, 37, 23);
  const auto frames = sample::frames(camera, 4, 2);
  auto writer = create_recording(posix_storage(), path, camera);
  REQUIRE(writer.ok());
  CHECK(sample::replay(posix_storage(), path).ended_with(ErrorCode::Truncated));
  for (std::size_t i = 0; i < frames.size(); ++i) {
    REQUIRE(writer.value()->append(frames[i]).ok());
    const auto replayed = sample::replay(posix_storage(), path);
    CHECK(replayed.ended_with(ErrorCode::Truncated));
    CHECK(replayed.frames.size() == i + 1);
    CHECK(replayed.is_start_of(frames));
  }
  REQUIRE(writer.value()->finish().ok());
  CHECK(!sample::replay(posix_storage(), path).error);
}

TEST_CASE(
    "a recording takes the place of an earlier one with its first frame, and without one leaves nothing") {
  const std::string folder = sample::scratch_folder("replaced"), path = folder + "/x.mkv";
  const CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, 37, 23);
  const auto earlier = sample::frames(camera, 3, 1), frames = sample::frames(camera, 2, 2);
  const auto files = [&] {
    return std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator());
  };
  const auto begun = [&] {
    return value_of(create_recording(posix_storage(), path, camera, Creation::Replace));
  };
  require_done(begun()->finish());
  CHECK(files() == 0);
  require_done(sample::record(posix_storage(), path, camera, earlier));
  (void)begun();  // and never finished
  require_done(begun()->finish());
  CHECK(sample::replay(posix_storage(), path).frames.size() == earlier.size());
  CHECK(files() == 1);

  const auto writer = begun();
  require_done(writer->append(frames[0]));
  const auto cut = sample::replay(posix_storage(), path);  // as a crash would leave it
  CHECK(cut.ended_with(ErrorCode::Truncated));
  CHECK(cut.frames.size() == 1);
  CHECK(cut.is_start_of(frames));
  require_done(writer->append(frames[1]));
  require_done(writer->finish());
  CHECK(!sample::replay(posix_storage(), path).error);
  CHECK(files() == 1);
}

TEST_CASE("a new recording for which the disk has no room leaves no file, and an earlier one stays") {
  const std::string folder = sample::scratch_folder("no_room"), path = folder + "/x.mkv";
  const CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, 37, 23);
  FaultyStorage full(posix_storage(), {.space_bytes = 0});
  const auto begun = [&] { return create_recording(full, path, camera, Creation::New); };
  require_error(begun(), ErrorCode::NoSpace);
  CHECK(std::filesystem::is_empty(folder));
  require_done(sample::record(posix_storage(), path, camera, sample::frames(camera, 1, 1)));
  require_error(begun(), ErrorCode::Exists);
  CHECK(sample::replay(posix_storage(), path).frames.size() == 1);
}

namespace {

// Memory ends with each new file, once it is there.
class DiskOfLastMemory : public ForwardingStorage {
 public:
  using ForwardingStorage::ForwardingStorage;
  Result<std::unique_ptr<StorageFile>> create(const std::string& path, Creation how) override {
    TRY(ForwardingStorage::create(path, how));
    return std::unique_ptr<StorageFile>(std::make_unique<LastFile>());
  }

 private:
  struct LastFile : StorageFile {
    Result<std::size_t> read_at(std::uint64_t, std::span<std::byte>) override { return std::size_t{0}; }
    Result<void> write_at(std::uint64_t, std::span<const std::byte>) override { return {}; }
    Result<std::uint64_t> size() override { return std::uint64_t{0}; }
    Result<void> sync() override { return {}; }
    Result<void> hold() override { throw std::bad_alloc(); }
  };
};

}  // namespace

TEST_CASE("a recording for which memory ends as it is begun leaves no file") {
  const std::string folder = sample::scratch_folder("begun_without_memory");
  DiskOfLastMemory disk(posix_storage());
  const CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, 64, 48);
  for (const Creation how : {Creation::New, Creation::Replace}) {
    CHECK_THROWS_AS(create_recording(disk, folder + "/x.mkv", camera, how), std::bad_alloc);
    CHECK(std::filesystem::is_empty(folder));
  }
}

TEST_CASE("a recording that is removed while it is written says so within a second, and never ends well") {
  const std::string path = sample::scratch_folder("removed") + "/x.mkv";
  const CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, 37, 23);
  const auto frames = sample::frames(camera, 40, 2);  // at 30 Hz
  for (const Creation how : {Creation::New, Creation::Replace})
    for (const std::size_t written : {std::size_t{3}, frames.size()}) {
      const auto writer = value_of(create_recording(posix_storage(), path, camera, how));
      require_done(writer->append(frames.front()));
      std::filesystem::remove(path);
      Result<void> appended;
      for (std::size_t i = 1; i < written && appended; ++i) appended = writer->append(frames[i]);
      CHECK(appended.ok() == (written == 3));
      const auto finished = writer->finish();
      require_error(finished, ErrorCode::NotFound);
      CHECK(finished.error().message ==
            fmt::format("'{}' was removed while it was written; its content is lost", path));
    }
}

TEST_CASE("an error in the middle of a recording names the file that was asked for") {
  const std::string path = sample::scratch_folder("named") + "/x.mkv";
  const CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, 37, 23);
  for (const std::uint64_t write : {1, 4, 8}) {
    FaultyStorage disk(posix_storage(), {.failing_write = write});
    const auto recorded = sample::record(disk, path, camera, sample::frames(camera, 9, 2));
    REQUIRE(!recorded.ok());
    INFO(recorded.error().message);
    CHECK(recorded.error().message.find(".part") == std::string::npos);
  }
}

TEST_CASE("what a recording cannot hold is refused with the value in the sentence") {
  const std::string path = sample::scratch_folder("refused") + "/x.mkv";
  const auto code_of = [&](const CameraFacts& camera) {
    const auto writer = create_recording(posix_storage(), path, camera);
    REQUIRE(!writer.ok());
    return writer.error();
  };
  CHECK(code_of(sample::camera(PixelLayout::Rgb, 7, 8, 8)).code == ErrorCode::Invalid);
  CHECK(code_of(sample::camera(PixelLayout::Rgb, 17, 8, 8)).message.find("17") != std::string::npos);
  CHECK(code_of(sample::camera(PixelLayout::Rgb, 8, 0, 8)).code == ErrorCode::Invalid);
  CHECK(code_of(sample::camera(PixelLayout::Mono, 8, 8, 1)).code == ErrorCode::Invalid);
  CHECK(code_of(sample::camera(PixelLayout::Rgb, 8, 8, 20000)).message.find("20000") != std::string::npos);

  const CameraFacts camera = sample::camera(PixelLayout::Rgb, 10, 8, 8);
  auto writer = create_recording(posix_storage(), path, camera);
  REQUIRE(writer.ok());
  const auto append_error = [&](const CameraFacts& other) {
    const auto appended = writer.value()->append(sample::frames(other, 1, 1)[0]);
    REQUIRE(!appended.ok());
    return appended.error().code;
  };
  CHECK(append_error(sample::camera(PixelLayout::Rgb, 10, 9, 8)) == ErrorCode::SizeChanged);
  CHECK(append_error(sample::camera(PixelLayout::Mono, 10, 8, 8)) == ErrorCode::SizeChanged);
  CHECK(append_error(sample::camera(PixelLayout::Rgb, 11, 8, 8)) == ErrorCode::Invalid);
  const auto facts_error = [&](FrameFacts facts) {
    auto refused = sample::frames(camera, 1, 1);
    refused[0].facts = std::move(facts);
    const auto appended = writer.value()->append(refused[0]);
    REQUIRE(!appended.ok());
    CHECK(appended.error().code == ErrorCode::Invalid);
    return appended.error().message;
  };
  // A refused frame leaves no trace.
  const auto frames = sample::frames(camera, 2, 1);
  REQUIRE(writer.value()->append(frames[0]).ok());
  FrameFacts earlier = frames[1].facts, again = frames[1].facts;
  earlier.timestamp = frames[0].facts.timestamp, again.sequence = frames[0].facts.sequence;
  CHECK_THAT(facts_error(earlier), Contains("frame 1 cannot be recorded: its time "));
  CHECK_THAT(facts_error(again), Contains("frame 1 cannot be recorded: its number 1152921504606846976 does"));
  REQUIRE(writer.value()->append(frames[1]).ok());
  REQUIRE(writer.value()->finish().ok());
  const auto replayed = sample::replay(posix_storage(), path);
  CHECK(!replayed.error);
  CHECK(replayed.frames.size() == 2);
  CHECK(replayed.is_start_of(frames));
}
