// What is read of a damaged recording where damage is skipped: every frame that is whole, whatever surrounds
// it.
#include <algorithm>
#include <filesystem>
#include <utility>

#include "hal/fault/faulty_storage.h"
#include "hal/recording/cluster_scan.h"
#include "hal/recording/facts_json.h"
#include "tests/hal/recording/small_recording.h"

#include "tests/support/files.h"

using namespace hdrcam;
using sample::small_recording;
using test::write_file;

namespace {

// Gives the frame of a recording that has this time another one, under a checksum that holds. Both have as
// many digits.
void forge_time(const std::string& path, Instant time, Instant forged) {
  const auto digits = [](Instant at) { return std::to_string(at.since_boot.count()); };
  std::string bytes = read_whole(posix_storage(), path).value();
  const auto file = posix_storage().open(path).value();
  ClusterScan scan(*file, 0, 1 << 20);
  for (;;) {
    const auto found = scan.next().value();
    REQUIRE(found);
    const std::size_t at = found->facts.find(digits(time));
    if (at == std::string::npos) continue;
    std::string json = found->facts.substr(0, found->facts.rfind(",\"crc32\"")) + "}";
    json.replace(at, digits(time).size(), digits(forged));
    const std::string sealed = seal(json, found->picture);
    REQUIRE(sealed.size() == found->facts.size());
    return write_file(path, bytes.replace(bytes.find(found->facts), sealed.size(), sealed));
  }
}

// All frames that the reader still has; an error fails the test.
std::vector<RawFrame> rest_of(RecordingReader& reader) {
  std::vector<RawFrame> read;
  for (;;) {
    auto frame = reader.next();
    INFO(sample::error_of(frame).message);
    REQUIRE(frame.ok());
    if (!frame.value()) return read;
    read.push_back(std::move(**frame));
  }
}

// Where the clusters of a recording begin.
std::vector<std::size_t> clusters_in(const std::string& bytes) {
  std::vector<std::size_t> clusters;
  for (std::size_t at = 0; (at = bytes.find("\x1f\x43\xb6\x75", at)) != std::string::npos; ++at)
    clusters.push_back(at);
  return clusters;
}

// Which frames of `whole` were read, by their places; a frame that is none of them fails the test.
std::vector<std::size_t> places_of(const std::vector<RawFrame>& read, const std::vector<RawFrame>& whole) {
  std::vector<std::size_t> places;
  for (const RawFrame& frame : read) {
    std::size_t place = 0;
    while (place < whole.size() && !sample::same(frame, whole[place])) ++place;
    REQUIRE(place < whole.size());
    places.push_back(place);
  }
  return places;
}

}  // namespace

TEST_CASE("behind a flipped bit all other frames are read, and the damaged one is named by its number") {
  const sample::StoredSample made = small_recording("salvage", PixelLayout::Mono);
  std::uint64_t first_cluster = 0, behind_frames = 0;
  {
    const std::string bytes = read_whole(posix_storage(), made.path).value();
    first_cluster = bytes.find("\x1f\x43\xb6\x75") + 4;  // its identifier ends the header
    behind_frames = bytes.find("{\"end\"");
  }
  int salvaged = 0;
  for (std::uint64_t bit = first_cluster * 8; bit < behind_frames * 8; ++bit) {
    FaultyStorage disk(posix_storage(), {.flipped_bits = {bit}});
    auto reader = open_recording(disk, made.path, Damage::IsSkipped);
    INFO("bit " << bit << " of byte " << bit / 8 << ", the first frame at byte " << first_cluster);
    REQUIRE(reader.ok());
    const auto places = places_of(rest_of(*reader.value()), made.frames);
    REQUIRE(std::is_sorted(places.begin(), places.end()));
    REQUIRE(places.size() + 1 >= made.frames.size());
    const LeftOut& left_out = reader.value()->left_out();
    REQUIRE(left_out.count == made.frames.size() - places.size());
    if (left_out.count == 0) continue;
    ++salvaged;
    REQUIRE(left_out.places.size() == 1);
    REQUIRE(std::find(places.begin(), places.end(), left_out.places[0]) == places.end());
    REQUIRE(left_out.sentence().find(fmt::format("left out: {}", left_out.places[0])) != std::string::npos);
  }
  CHECK(salvaged > 1000);
}

TEST_CASE("a hole in a recording costs the frames that were in it") {
  const sample::StoredSample made = small_recording("hole");
  const std::string bytes = read_whole(posix_storage(), made.path).value();
  const std::vector<std::size_t> clusters = clusters_in(bytes);
  REQUIRE(clusters.size() >= 5);
  std::string holed = bytes;
  const std::size_t begin = clusters[1] + 40, end = clusters[2] + 60;
  const bool closed = GENERATE(false, true);
  CAPTURE(closed);
  if (closed)
    holed.erase(begin, end - begin);
  else
    std::fill_n(holed.begin() + static_cast<long>(begin), end - begin, '\0');
  write_file(made.path, holed);
  auto reader = open_recording(posix_storage(), made.path, Damage::IsSkipped);
  REQUIRE(reader.ok());
  CHECK(places_of(rest_of(*reader.value()), made.frames) == std::vector<std::size_t>{0, 3});
  CHECK(reader.value()->left_out().count == 2);
  CHECK(reader.value()->left_out().places == std::vector<std::uint64_t>{1, 2});
}

TEST_CASE("a damaged header is called so, and no cut, however the recording ends") {
  const sample::StoredSample made = small_recording("header_hole");
  const std::string bytes = read_whole(posix_storage(), made.path).value();
  const std::vector<std::size_t> clusters = clusters_in(bytes);
  constexpr std::size_t kHead = 10, kHole = 50;  // bytes: the segment's head with its size is among them
  REQUIRE(clusters.front() > kHead + kHole);
  for (const std::size_t length : {bytes.size(), clusters[2]}) {
    std::string holed = bytes.substr(0, length);
    holed.replace(kHead, kHole, std::string(kHole, '\0'));
    write_file(made.path, holed);
    const auto opened = open_recording(posix_storage(), made.path, Damage::IsSkipped);
    REQUIRE_FALSE(opened.ok());
    CHECK(opened.error().code == ErrorCode::Corrupt);
    CHECK(opened.error().message == fmt::format("'{}' is damaged: its header cannot be read", made.path));
  }
}

TEST_CASE("a damaged size that leads right to a later frame costs no frame between") {
  const sample::StoredSample made = small_recording("overlong");
  std::string bytes = read_whole(posix_storage(), made.path).value();
  const std::vector<std::size_t> clusters = clusters_in(bytes);
  REQUIRE(clusters.size() > 3);
  const auto byte = [&](std::size_t at) { return std::size_t{static_cast<std::uint8_t>(bytes[at])}; };
  std::size_t block = clusters[1] + 4;    // behind the cluster's identifier
  block += byte(block) >= 0x80 ? 1 : 2;   // its size
  block += 6;                             // its checksum
  block += 2 + (byte(block + 1) & 0x7f);  // its time
  REQUIRE(byte(block) == 0xa3);
  REQUIRE((byte(block + 1) & 0xc0) == 0x40);  // a size of two bytes
  const std::size_t size = clusters[3] - (block + 3);
  bytes[block + 1] = static_cast<char>(0x40 | size >> 8);
  bytes[block + 2] = static_cast<char>(size & 0xff);
  write_file(made.path, bytes);
  auto reader = open_recording(posix_storage(), made.path, Damage::IsSkipped);
  REQUIRE(reader.ok());
  CHECK(places_of(rest_of(*reader.value()), made.frames) == std::vector<std::size_t>{0, 2, 3});
  CHECK(reader.value()->left_out().places == std::vector<std::uint64_t>{1});
}

TEST_CASE("bytes of later frames that stand at an earlier place, too, cost no other frame") {
  const sample::StoredSample made = small_recording("copied");
  const std::string bytes = read_whole(posix_storage(), made.path).value();
  std::vector<std::size_t> places = clusters_in(bytes);
  REQUIRE(places.size() == 5);                                      // four frames and the end record
  places.push_back(bytes.find("\x1c\x53\xbb\x6b", places.back()));  // the index
  struct Run {
    std::size_t first, behind, before;  // clusters
  };
  const Run run = GENERATE(Run{3, 4, 1}, Run{2, 4, 0}, Run{4, 5, 1});  // the last: the end record
  CAPTURE(run.first, run.before);
  std::string copied = bytes;
  copied.insert(places[run.before], bytes.substr(places[run.first], places[run.behind] - places[run.first]));
  write_file(made.path, copied);
  auto reader = open_recording(posix_storage(), made.path, Damage::IsSkipped);
  REQUIRE(reader.ok());
  CHECK(places_of(rest_of(*reader.value()), made.frames) == std::vector<std::size_t>{0, 1, 2, 3});
  CHECK(reader.value()->left_out().count == 0);
  CHECK_FALSE(reader.value()->left_out().end_is_missing);
}

TEST_CASE("where the end of a recording is overwritten nobody says that no frame is lost") {
  const sample::StoredSample made = small_recording("blank_end");
  const std::string bytes = read_whole(posix_storage(), made.path).value();
  const std::vector<std::size_t> clusters = clusters_in(bytes);
  REQUIRE(clusters.size() == 5);               // four frames and the end record
  const bool besides = GENERATE(false, true);  // frame 1 is damaged, too
  CAPTURE(besides);
  std::string blanked = bytes;
  std::fill(blanked.begin() + static_cast<long>(clusters[3]), blanked.end(), '\0');
  if (besides) blanked[bytes.find("\"index\":1", clusters[1]) + 8] = '7';
  write_file(made.path, blanked);
  auto reader = open_recording(posix_storage(), made.path, Damage::IsSkipped);
  REQUIRE(reader.ok());
  CHECK_FALSE(reader.value()->frame_count());
  CHECK(rest_of(*reader.value()).size() == (besides ? 2 : 3));
  const LeftOut& left_out = reader.value()->left_out();
  CHECK(left_out.count == (besides ? 1 : 0));
  CHECK(left_out.sentence().find("frames may be lost at the end") != std::string::npos);
  CHECK(left_out.sentence().find("no frame is lost") == std::string::npos);
}

TEST_CASE("where a recording was cut and is damaged besides nobody says so either") {
  const sample::StoredSample made = small_recording("cut_and_damaged");
  std::string bytes = read_whole(posix_storage(), made.path).value();
  bytes[bytes.find("\"index\":1") + 8] = '0';  // the frame behind it is cut, too: nothing proves the loss
  write_file(made.path, bytes.substr(0, clusters_in(bytes)[2] + 40));
  auto reader = open_recording(posix_storage(), made.path, Damage::IsSkipped);
  REQUIRE(reader.ok());
  REQUIRE(value_of(reader.value()->next()).has_value());
  const auto end = reader.value()->next();
  REQUIRE_FALSE(end.ok());
  CHECK(end.error().code == ErrorCode::Truncated);
  CHECK(reader.value()->left_out().sentence().find("frames may be lost at the end") != std::string::npos);
}

TEST_CASE("frames of another recording that was put behind a cut one are none of its frames") {
  const sample::StoredSample made = small_recording("spliced"), other = small_recording("spliced_other");
  const std::string bytes = read_whole(posix_storage(), made.path).value();
  const std::vector<std::size_t> clusters = clusters_in(bytes);
  REQUIRE(clusters.size() > 2);
  write_file(made.path, bytes.substr(0, clusters[2] + 40) + read_whole(posix_storage(), other.path).value());
  auto reader = open_recording(posix_storage(), made.path, Damage::IsSkipped);
  REQUIRE(reader.ok());
  CHECK(rest_of(*reader.value()).size() == 2);
  const LeftOut& left_out = reader.value()->left_out();
  CHECK(left_out.count == 0);  // the end record of the other one does not count them
  CHECK(left_out.sentence().find("frames may be lost at the end") != std::string::npos);
  CHECK(reader.value()->bytes_behind() == other.bytes);
}

TEST_CASE(
    "behind a recording that was never completed another one is told of, too, once its end is reached") {
  const sample::StoredSample made = small_recording("unfinished"),
                             other = small_recording("unfinished_other");
  const std::string path = made.path + ".steps";
  std::string begun;
  {
    auto writer = create_recording(posix_storage(), path, made.camera).value();
    REQUIRE(writer->append(made.frames[0]).ok());
    REQUIRE(writer->append(made.frames[1]).ok());
    begun = read_whole(posix_storage(), path).value();
  }
  const auto frames_in = [](RecordingReader& reader) {
    int frames = 0;
    for (auto facts = reader.next_facts(); facts && facts.value(); facts = reader.next_facts()) ++frames;
    return frames;
  };
  const bool cut = GENERATE(false, true);  // in the middle of frame 1
  CAPTURE(cut);
  if (cut) begun.resize(begun.size() - 60);
  for (const Damage damage : {Damage::Ends, Damage::IsSkipped}) {
    write_file(path, begun);
    const auto alone = open_recording(posix_storage(), path, damage).value();
    CHECK(frames_in(*alone) == (cut ? 1 : 2));
    CHECK(alone->bytes_behind() == 0);
    write_file(path, begun + read_whole(posix_storage(), other.path).value());
    const auto reader = open_recording(posix_storage(), path, damage).value();
    CHECK(frames_in(*reader) == (cut ? 1 : 2));
    if (damage == Damage::IsSkipped) CHECK(reader->bytes_behind() == other.bytes);
  }
}

TEST_CASE("another recording behind a complete one is told of, and none of its frames is read") {
  const sample::StoredSample made = small_recording("joined"), other = small_recording("joined_other");
  CHECK(open_recording(posix_storage(), made.path).value()->bytes_behind() == 0);
  const std::string bytes = read_whole(posix_storage(), made.path).value();
  write_file(made.path, bytes + read_whole(posix_storage(), other.path).value());
  const auto replayed = sample::replay(posix_storage(), made.path);
  CHECK_FALSE(replayed.error);
  CHECK(replayed.frames.size() == made.frames.size());
  CHECK(replayed.is_start_of(made.frames));
  const auto reader = open_recording(posix_storage(), made.path).value();
  CHECK(reader->bytes_behind() == other.bytes);
  CHECK(told_of_behind(*reader) ==
        fmt::format(
            "another recording, of {0} bytes, follows this one in the file and is not read; 'tail -c {0} "
            "FILE > other.mkv' takes it out",
            other.bytes));

  write_file(made.path, bytes + "whatever else");
  CHECK(told_of_behind(*open_recording(posix_storage(), made.path).value()).empty());
}

TEST_CASE("a frame whose number or time runs backwards is damage, proved checksum or not") {
  const sample::StoredSample made = small_recording("backwards");
  const Instant earlier = made.frames[1].facts.timestamp + Duration(-1);
  forge_time(made.path, made.frames[2].facts.timestamp, earlier);  // the writer refuses it
  const auto strict = sample::replay(posix_storage(), made.path);
  CHECK(strict.ended_with(ErrorCode::Corrupt));
  CHECK(strict.frames.size() == 2);
  CHECK(strict.error->message.find("frame 2: its time") != std::string::npos);
  auto reader = open_recording(posix_storage(), made.path, Damage::IsSkipped);
  REQUIRE(reader.ok());
  CHECK(rest_of(*reader.value()).size() == 3);
  CHECK(reader.value()->left_out().places == std::vector<std::uint64_t>{2});
}
