// A file of sections: whole it comes back to the byte, and whatever is cut or changed of it is told.
#include "hal/sections/section_file.h"

#include <cstring>

#include "hal/sections/fact_fields.h"
#include "tests/support/scratch_folder.h"

#include "tests/support/files.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;
using test::text_of;
using test::write_file;

namespace {

constexpr SectionFormat kFormat{.what = "a box of letters",
                                .magic = {'l', 'e', 't', 't', 'e', 'r', 's', '\n'},
                                .version = 1,
                                .mend = "write it again"};
constexpr std::size_t kVersionAt = 8, kFirstAt = 12;

Bytes bytes_of(const std::string& text) { return std::as_bytes(std::span(text)); }

// Of two sections, "first" and "second".
std::string written(const std::string& name) {
  const std::string path = test::scratch_folder(name) + "/box";
  SectionWriter writer =
      value_of(SectionWriter::create(value_of(FileInMaking::beside(posix_storage(), path)), kFormat));
  const std::string a = "abc", b = "defg", c = "hij";
  const Bytes parts[] = {bytes_of(a), bytes_of(b)};
  require_done(writer.add("first", parts));
  require_done(writer.add("second", bytes_of(c)));
  CHECK_FALSE(is_there(posix_storage(), path));  // until it is complete
  require_done(writer.finish());
  return path;
}

Result<std::string> read_all(const std::string& path) {
  SectionReader reader = TRY(SectionReader::open(posix_storage(), path, kFormat));
  std::string text;
  for (const char* name : {"first", "second"}) {
    TRY(reader.begin(name));
    std::string content(static_cast<std::size_t>(reader.length()), ' ');
    TRY(reader.read(std::as_writable_bytes(std::span(content))));
    TRY(reader.end());
    text += content + '.';
  }
  TRY(reader.end_of_file());
  return text;
}

Result<void> checked(const std::string& path) {
  SectionReader reader = TRY(SectionReader::open(posix_storage(), path, kFormat));
  return reader.pass_to_end();
}

}  // namespace

TEST_CASE("sections come back as they were written, in their order") {
  const std::string path = written("sections_whole");
  CHECK(value_of(read_all(path)) == "abcdefg.hij.");
  CHECK(checked(path).ok());
  CHECK(value_of(is_section_file(posix_storage(), path, kFormat)));
}

TEST_CASE("a file of sections that is cut anywhere is no whole one, and says where it ends") {
  const std::string path = written("sections_cut"), whole = text_of(path);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    write_file(path, whole.substr(0, size));
    const auto read = read_all(path);
    INFO(size);
    REQUIRE_FALSE(read.ok());
    CHECK(read.error().code == (size < kVersionAt ? ErrorCode::NotRecording : ErrorCode::Truncated));
    CHECK_THAT(read.error().message, Contains(path));
    CHECK_FALSE(checked(path).ok());
  }
}

TEST_CASE("a flipped bit anywhere in a file of sections is found before its content counts") {
  const std::string path = written("sections_flipped"), whole = text_of(path);
  for (std::size_t at = 0; at < whole.size(); ++at)
    for (const int bit : {0, 7}) {
      std::string damaged = whole;
      damaged[at] = static_cast<char>(damaged[at] ^ (1 << bit));
      write_file(path, damaged);
      const auto read = read_all(path);
      INFO(at << ", bit " << bit);
      REQUIRE_FALSE(read.ok());
      CHECK_THAT(read.error().message, Contains(path));
      CHECK_FALSE(checked(path).ok());
    }
}

TEST_CASE("a newer version of a file of sections is refused by its number, and one without a number too") {
  const std::string path = written("sections_newer");
  std::string text = text_of(path);
  text[kVersionAt] = 4;
  write_file(path, text);
  const auto newer = read_all(path);
  REQUIRE_FALSE(newer.ok());
  CHECK(newer.error().code == ErrorCode::Unsupported);
  CHECK_THAT(newer.error().message, Contains("of version 4, and this program reads up to version 1"));
  text[kVersionAt] = 0;
  write_file(path, text);
  CHECK(read_all(path).error().code == ErrorCode::Corrupt);
}

TEST_CASE("a length that the file cannot hold is refused before memory is taken for it") {
  const std::string path = test::scratch_folder("sections_long") + "/box";
  struct Head {
    char name[16] = "first";
    std::uint64_t length = std::uint64_t{1} << 60;
    std::uint32_t content = 0, head = 0;
  } head;
  // its checksum, found as a writer would
  std::string text = text_of(written("sections_long_from")).substr(0, kFirstAt);
  std::uint32_t crc = ~0u;
  const auto* byte = reinterpret_cast<const unsigned char*>(&head);
  for (std::size_t i = 0; i < 28; ++i) {
    crc ^= byte[i];
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1) != 0 ? 0xedb88320u : 0u);
  }
  head.head = ~crc;
  text.append(reinterpret_cast<const char*>(&head), sizeof head);
  write_file(path, text + "abc");
  SectionReader reader = value_of(SectionReader::open(posix_storage(), path, kFormat));
  const auto next = reader.next();
  REQUIRE_FALSE(next.ok());
  CHECK(next.error().code == ErrorCode::Truncated);
  CHECK_THAT(next.error().message, Contains("section 'first' has 3 of 1152921504606846976 bytes"));
}

TEST_CASE("a file of sections that is not finished leaves the earlier one as it is, and nothing besides") {
  const std::string path = written("sections_unfinished"), whole = text_of(path);
  {
    SectionWriter writer =
        value_of(SectionWriter::create(value_of(FileInMaking::beside(posix_storage(), path)), kFormat));
    require_done(writer.add("first", bytes_of(whole)));
  }
  CHECK(text_of(path) == whole);
  CHECK(std::distance(std::filesystem::directory_iterator(std::filesystem::path(path).parent_path()), {}) ==
        1);
}

TEST_CASE("another section than the expected one is damage, named with what should be there") {
  const std::string path = written("sections_other");
  SectionReader reader = value_of(SectionReader::open(posix_storage(), path, kFormat));
  const auto second = reader.begin("second");
  REQUIRE_FALSE(second.ok());
  CHECK(second.error().code == ErrorCode::Corrupt);
  CHECK_THAT(second.error().message, Contains("section 'first': 'second' should stand in its place"));
}

TEST_CASE("the facts of a frame and of a camera come back from their bytes, and from no fewer or more") {
  FrameFacts facts;
  facts.sequence = 77, facts.timestamp = Instant::from_seconds(1.25), facts.exposure_s = 0.004;
  facts.black_level = BlackLevel(16), facts.verdict = Verdict::Plausible, facts.exposure_within_ev = 0.1;
  facts.exposure_source = ExposureSource::Reported, facts.T_world_camera.emplace()[3] = 2.5;
  facts.analogue_gain = 2, facts.digital_gain = 1.5, facts.readout_s = 0.012, facts.slot = 2;
  facts.flags = kFrameAfterDrop | kFrameTriggerLate;
  CameraFacts camera;
  camera.name = "a camera", camera.width = 64, camera.height = 48, camera.layout = PixelLayout::BayerGbrg;
  camera.framerate_hz = 25, camera.bits = 12, camera.linear = true, camera.white_balance = {2, 1, 1.5};
  camera.response = {{0.5, 1}, {}};
  FieldsOut out;
  out(facts, camera);
  FrameFacts facts_back;
  CameraFacts camera_back;
  FieldsIn in(out.bytes());
  in(facts_back, camera_back);
  CHECK(in.complete());
  CHECK(facts_back.sequence == 77);
  CHECK(facts_back.timestamp == facts.timestamp);
  CHECK(facts_back.exposure_s == facts.exposure_s);
  CHECK(facts_back.analogue_gain == facts.analogue_gain);
  CHECK(facts_back.digital_gain == facts.digital_gain);
  CHECK(facts_back.readout_s == facts.readout_s);
  CHECK(facts_back.slot == facts.slot);
  CHECK(facts_back.exposure_within_ev == facts.exposure_within_ev);
  CHECK(facts_back.flags == facts.flags);
  CHECK(facts_back.black_level == facts.black_level);
  CHECK(facts_back.verdict == facts.verdict);
  CHECK(facts_back.exposure_source == facts.exposure_source);
  CHECK(facts_back.T_world_camera == facts.T_world_camera);
  CHECK(camera_back.name == camera.name);
  CHECK(camera_back.width == camera.width);
  CHECK(camera_back.height == camera.height);
  CHECK(camera_back.framerate_hz == camera.framerate_hz);
  CHECK(camera_back.bits == camera.bits);
  CHECK(camera_back.linear);
  CHECK(camera_back.white_balance == camera.white_balance);
  CHECK(camera_back.layout == camera.layout);
  CHECK(camera_back.response == camera.response);
  CHECK_FALSE(camera_back.intrinsics.has_value());
  for (std::size_t size = 0; size < out.bytes().size(); ++size) {
    FieldsIn short_of(out.bytes().first(size));
    short_of(facts_back, camera_back);
    CHECK_FALSE(short_of.complete());
  }
  FieldsIn more(out.bytes());
  more(facts_back);
  CHECK_FALSE(more.complete());
}
