// Every way in which a file can be damaged: cut, flipped, not written to the end, never one of ours.
#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <utility>

#include "hal/core/counted.h"
#include "hal/fault/faulty_storage.h"
#include "hal/recording/cluster_scan.h"
#include "hal/recording/facts_json.h"
#include "hal/recording/recording.h"
#include "tests/hal/recording/sample_recordings.h"

#include "tests/support/files.h"

using namespace hdrcam;
using test::write_file;

namespace {

struct Sample {
  std::string path;
  CameraFacts camera;
  std::vector<RawFrame> frames;
  std::uint64_t bytes = 0;
};

Sample small_recording(const std::string& name, PixelLayout layout = PixelLayout::Rgb) {
  Sample made{sample::scratch_folder(name) + "/x.mkv", sample::camera(layout, 8, 7, 5), {}, 0};
  made.frames = sample::frames(made.camera, 4, 21);
  REQUIRE(sample::record(posix_storage(), made.path, made.camera, made.frames).ok());
  made.bytes = std::filesystem::file_size(made.path);
  return made;
}

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

}  // namespace

TEST_CASE("a recording cut at any byte reads up to its last whole frame and says that it was cut") {
  const Sample made = small_recording("cut");
  // Where each frame is whole, found by recording step by step.
  std::vector<std::uint64_t> whole_at;
  {
    const std::string path = made.path + ".steps";
    auto writer = create_recording(posix_storage(), path, made.camera);
    REQUIRE(writer.ok());
    for (const RawFrame& frame : made.frames) {
      REQUIRE(writer.value()->append(frame).ok());
      whole_at.push_back(std::filesystem::file_size(path));
    }
  }
  std::size_t complete = 0;
  for (std::uint64_t cut = 0; cut <= made.bytes; ++cut) {
    FaultyStorage disk(posix_storage(), {.cut_at_bytes = cut});
    const auto replayed = sample::replay(disk, made.path);
    INFO("cut at byte " << cut << " of " << made.bytes << ": "
                        << (replayed.error ? replayed.error->message : std::string("complete")));
    const auto expected =
        std::count_if(whole_at.begin(), whole_at.end(), [&](auto end) { return end <= cut; });
    REQUIRE(static_cast<long>(replayed.frames.size()) == expected);
    REQUIRE(replayed.is_start_of(made.frames));
    if (replayed.error) {
      REQUIRE(replayed.error->code == ErrorCode::Truncated);
      if (expected > 0)
        REQUIRE(replayed.error->message.find(fmt::format("was cut after {}, or is still being written",
                                                         counted(expected, "whole frame"))) !=
                std::string::npos);
    } else {
      ++complete;
      REQUIRE(expected == 4);
    }
  }
  // Only a cut behind the end record, in the index, may go unnoticed: nothing is lost there.
  CHECK(complete > 0);
  CHECK(complete < made.bytes - whole_at.back());
}

TEST_CASE("a cut recording does not claim to know its number of frames") {
  const Sample made = small_recording("cutcount");
  FaultyStorage disk(posix_storage(), {.cut_at_bytes = made.bytes - 1});
  const auto reader = open_recording(disk, made.path);
  REQUIRE(reader.ok());
  CHECK(!reader.value()->frame_count());
}

TEST_CASE("a flipped bit never gives a wrong frame and never a silent gap") {
  const Sample made = small_recording("flip", PixelLayout::Mono);
  int noticed = 0;
  for (std::uint64_t bit = 0; bit < made.bytes * 8; ++bit) {
    FaultyStorage disk(posix_storage(), {.flipped_bits = {bit}});
    const auto replayed = sample::replay(disk, made.path);
    INFO("bit " << bit << ": " << (replayed.error ? replayed.error->message : std::string("complete")));
    REQUIRE(replayed.is_start_of(made.frames));
    if (!replayed.error) REQUIRE(replayed.frames.size() == made.frames.size());
    if (replayed.error) {
      ++noticed;
      REQUIRE((replayed.ended_with(ErrorCode::Corrupt) || replayed.ended_with(ErrorCode::Truncated) ||
               replayed.ended_with(ErrorCode::NotRecording) || replayed.ended_with(ErrorCode::Unsupported)));
    }
  }
  CHECK(noticed > 0);
}

TEST_CASE("many flipped bits never give a wrong frame") {
  const Sample made = small_recording("flips");
  std::mt19937 random(99);
  for (int trial = 0; trial < 2000; ++trial) {
    StorageFaults faults;
    const auto count = 1 + random() % 40;
    for (unsigned i = 0; i < count; ++i) faults.flipped_bits.push_back(random() % (made.bytes * 8));
    if (trial % 3 == 0) faults.cut_at_bytes = random() % made.bytes;
    FaultyStorage disk(posix_storage(), faults);
    const auto replayed = sample::replay(disk, made.path);
    INFO("trial " << trial);
    REQUIRE(replayed.is_start_of(made.frames));
    if (!replayed.error) REQUIRE(replayed.frames.size() == made.frames.size());
  }
}

TEST_CASE("a flipped bit in the pixels is corruption at that frame, found by the checksum") {
  const std::string path = sample::scratch_folder("pixel") + "/x.mkv";
  const CameraFacts camera = sample::camera(PixelLayout::Mono, 16, 64, 48);
  const auto frames = sample::frames(camera, 3, 4);
  REQUIRE(sample::record(posix_storage(), path, camera, frames).ok());
  // Random 16-bit codes do not compress: the middle of the file is in the pixels of frame 1.
  FaultyStorage disk(posix_storage(), {.flipped_bits = {std::filesystem::file_size(path) * 4}});
  for (const bool decode : {true, false}) {
    auto reader = open_recording(disk, path);
    REQUIRE(reader.ok());
    REQUIRE(reader.value()->next_facts().ok());
    const auto error = decode ? reader.value()->next().error() : reader.value()->next_facts().error();
    CHECK(error.code == ErrorCode::Corrupt);
    CHECK(error.message.find("frame 1") != std::string::npos);
    CHECK(error.message.find(path) != std::string::npos);
  }
}

TEST_CASE("a full disk comes back as such and leaves a recording of whole frames") {
  const Sample made = small_recording("full");
  for (std::uint64_t space = 0; space < made.bytes; space += 7) {
    FaultyStorage disk(posix_storage(), {.space_bytes = space});
    const std::string path = made.path + ".full";
    const auto recorded = sample::record(disk, path, made.camera, made.frames);
    INFO("room for " << space << " of " << made.bytes << " bytes");
    REQUIRE(!recorded.ok());
    REQUIRE(sample::error_of(recorded).code == ErrorCode::NoSpace);
    REQUIRE(recorded.error().message.find(path) != std::string::npos);
    REQUIRE(sample::replay(posix_storage(), path).is_start_of(made.frames));
  }
}

TEST_CASE("after a refused write the recording holds what was appended before, and the error stays") {
  const Sample made = small_recording("eio");
  const std::string path = made.path + ".eio";
  std::uint64_t all_writes = 0;
  {
    FaultyStorage disk(posix_storage(), {});
    REQUIRE(sample::record(disk, path, made.camera, made.frames).ok());
    all_writes = disk.writes();
  }
  REQUIRE(all_writes > made.frames.size());
  for (std::uint64_t refused = 0; refused < all_writes; ++refused) {
    INFO("write " << refused << " of " << all_writes);
    (void)posix_storage().remove(path);
    FaultyStorage disk(posix_storage(), {.failing_write = refused});
    auto writer = create_recording(disk, path, made.camera, Creation::Replace);
    std::size_t appended = 0;
    if (!writer) {
      REQUIRE(sample::error_of(writer).code == ErrorCode::Io);
      continue;
    }
    Result<void> last;
    for (const RawFrame& frame : made.frames) {
      last = writer.value()->append(frame);
      if (!last) break;
      ++appended;
    }
    if (last.ok()) last = writer.value()->finish();
    REQUIRE(!last.ok());
    REQUIRE(sample::error_of(last).code == ErrorCode::Io);
    REQUIRE(last.error().sys_errno == EIO);
    REQUIRE(sample::error_of(writer.value()->append(made.frames[0])).code == ErrorCode::Io);
    REQUIRE(sample::error_of(writer.value()->finish()).code == ErrorCode::Io);
    const auto replayed = sample::replay(posix_storage(), path);
    REQUIRE(replayed.frames.size() == appended);
    REQUIRE(replayed.is_start_of(made.frames));
  }
}

namespace {

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
  const Sample made = small_recording("salvage", PixelLayout::Mono);
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
  const Sample made = small_recording("hole");
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

TEST_CASE("a damaged size that leads right to a later frame costs no frame between") {
  const Sample made = small_recording("overlong");
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
  const Sample made = small_recording("copied");
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
  const Sample made = small_recording("blank_end");
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
  const Sample made = small_recording("cut_and_damaged");
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
  const Sample made = small_recording("spliced"), other = small_recording("spliced_other");
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
  const Sample made = small_recording("unfinished"), other = small_recording("unfinished_other");
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
  const Sample made = small_recording("joined"), other = small_recording("joined_other");
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
  const Sample made = small_recording("backwards");
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

TEST_CASE("a lens that cannot be is refused when the recording is opened") {
  Sample made = small_recording("lens");
  made.camera.intrinsics = Intrinsics{1e40, 300, 3, 2};
  REQUIRE(sample::record(posix_storage(), made.path, made.camera, made.frames).ok());
  const auto replayed = sample::replay(posix_storage(), made.path);
  CHECK(replayed.ended_with(ErrorCode::Corrupt));
  CHECK(replayed.error->message.find("'fx' is 1e+40") != std::string::npos);
}

TEST_CASE("a disk that refuses to sync or to read is reported") {
  const Sample made = small_recording("sync");
  {
    FaultyStorage disk(posix_storage(), {.failing_sync = 0});
    const auto recorded = sample::record(disk, made.path + ".sync", made.camera, made.frames);
    REQUIRE(!recorded.ok());
    CHECK(sample::error_of(recorded).code == ErrorCode::Io);
  }
  std::uint64_t all_reads = 0;
  {
    FaultyStorage disk(posix_storage(), {});
    REQUIRE(!sample::replay(disk, made.path).error);
    all_reads = disk.reads();
  }
  REQUIRE(all_reads > 2);
  for (std::uint64_t refused = 0; refused < all_reads; ++refused) {
    FaultyStorage disk(posix_storage(), {.failing_read = refused});
    const auto replayed = sample::replay(disk, made.path);
    INFO("read " << refused << " of " << all_reads);
    REQUIRE(replayed.is_start_of(made.frames));
    // Reading the number of frames ahead is a convenience: its failure is not one of the recording.
    if (replayed.error)
      REQUIRE(replayed.error->code == ErrorCode::Io);
    else
      REQUIRE(replayed.frames.size() == made.frames.size());
  }
}

TEST_CASE("a recording is on the disk once per second that it lasts, and when it is finished") {
  const std::string path = sample::scratch_folder("durable") + "/x.mkv";
  const CameraFacts camera = sample::camera(PixelLayout::Mono, 8, 16, 16);
  const auto frames = sample::frames(camera, 65, 1);  // at 29.97 Hz
  FaultyStorage disk(posix_storage(), {});
  auto writer = create_recording(disk, path, camera);
  REQUIRE(writer.ok());
  REQUIRE(writer.value()->append(frames[0]).ok());
  std::uint64_t synced = disk.syncs(), before_the_second = 0;
  std::vector<std::size_t> synced_at;
  for (std::size_t i = 1; i < frames.size(); ++i) {
    if (i == 60) before_the_second = disk.syncs();
    REQUIRE(writer.value()->append(frames[i]).ok());
    if (std::exchange(synced, disk.syncs()) != disk.syncs()) synced_at.push_back(i);
  }
  CHECK(synced_at == std::vector<std::size_t>{30, 60});
  REQUIRE(writer.value()->finish().ok());
  CHECK(disk.syncs() > synced);

  FaultyStorage failing(posix_storage(), {.failing_sync = before_the_second});
  auto ended = create_recording(failing, path + "2", camera);
  REQUIRE(ended.ok());
  for (std::size_t i = 0; i < 60; ++i) REQUIRE(ended.value()->append(frames[i]).ok());
  CHECK(sample::error_of(ended.value()->append(frames[60])).code == ErrorCode::Io);
  CHECK(sample::error_of(ended.value()->append(frames[61])).code == ErrorCode::Io);
}

TEST_CASE("a file that is not a recording is said to be none") {
  const std::string folder = sample::scratch_folder("foreign");
  const std::string path = folder + "/x.mkv";
  SECTION("it does not exist") {
    CHECK(sample::replay(posix_storage(), path).ended_with(ErrorCode::NotFound));
  }
  SECTION("it is empty") {
    write_file(path, "");
    CHECK(sample::replay(posix_storage(), path).ended_with(ErrorCode::Truncated));
  }
  SECTION("it is a PNG") {
    write_file(path, "\x89PNG\r\n\x1a\n and so on");
    const auto replayed = sample::replay(posix_storage(), path);
    CHECK(replayed.ended_with(ErrorCode::NotRecording));
    CHECK(replayed.error->message == "'" + path +
                                         "' is not a recording: it is no Matroska file; 'hdrcam "
                                         "import' makes a recording of pictures, videos and clips");
  }
  SECTION("it is noise") {
    std::mt19937 random(3);
    std::string noise(5000, '\0');
    for (char& byte : noise) byte = static_cast<char>(random());
    write_file(path, noise);
    CHECK(sample::replay(posix_storage(), path).ended_with(ErrorCode::NotRecording));
  }
  SECTION("it is a Matroska file of somebody else") {
    const CameraFacts camera = sample::camera(PixelLayout::Mono, 8, 8, 8);
    REQUIRE(sample::record(posix_storage(), path, camera, sample::frames(camera, 1, 1)).ok());
    auto bytes = read_whole(posix_storage(), path).value();
    bytes.replace(bytes.find("HDRCAM_CAMERA"), 13, "SOME_BODYELSE");
    write_file(path, bytes);
    const auto replayed = sample::replay(posix_storage(), path);
    CHECK(replayed.ended_with(ErrorCode::NotRecording));
    CHECK(replayed.error->message.find("not a recording of hdrcam") != std::string::npos);
  }
  SECTION("it is a folder") {
    const auto replayed = sample::replay(posix_storage(), folder);
    CHECK(replayed.ended_with(ErrorCode::NotRecording));
    CHECK(replayed.error->message.find("is a folder and not a recording") != std::string::npos);
  }
}
