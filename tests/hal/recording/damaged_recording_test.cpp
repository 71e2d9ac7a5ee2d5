// Every way in which a file can be damaged: cut, flipped, not written to the end, never one of ours. What is
// read all the same where damage is skipped: salvaged_recording_test.cpp.
#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <utility>

#include "hal/core/counted.h"
#include "hal/fault/faulty_storage.h"
#include "hal/recording/recording.h"
#include "tests/hal/recording/small_recording.h"

#include "tests/support/files.h"

using namespace hdrcam;
using sample::small_recording;
using test::write_file;

TEST_CASE("a recording cut at any byte reads up to its last whole frame and says that it was cut") {
  const sample::StoredSample made = small_recording("cut");
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
      REQUIRE((replayed.error->message.find("is empty; copy it again") != std::string::npos) == (cut == 0));
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

TEST_CASE("a recording that is cut while it is read ends behind its last whole frame and says so") {
  const std::string path = sample::scratch_folder("cut_meanwhile") + "/x.mkv";
  const CameraFacts camera = sample::camera(PixelLayout::Rgb, 8, 128, 96);
  const auto frames = sample::frames(camera, 8, 4);  // far more bytes than are read ahead
  for (const Damage damage : {Damage::Ends, Damage::IsSkipped}) {
    require_done(sample::record(posix_storage(), path, camera, frames));
    const auto reader = value_of(open_recording(posix_storage(), path, damage));
    std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
    int read = 0;
    auto next = reader->next();
    for (; next && next.value(); next = reader->next()) ++read;
    CHECK(read > 1);
    CHECK(read < 8);
    require_error(next, ErrorCode::Truncated);
    CHECK(next.error().message ==
          fmt::format("'{}' was cut while it was read, after {} whole frames of 8", path, read));
    CHECK(reader->left_out().count == 0);
  }
}

TEST_CASE("a cut recording does not claim to know its number of frames") {
  const sample::StoredSample made = small_recording("cutcount");
  FaultyStorage disk(posix_storage(), {.cut_at_bytes = made.bytes - 1});
  const auto reader = open_recording(disk, made.path);
  REQUIRE(reader.ok());
  CHECK(!reader.value()->frame_count());
}

TEST_CASE("a flipped bit never gives a wrong frame and never a silent gap") {
  const sample::StoredSample made = small_recording("flip", PixelLayout::Mono);
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
  const sample::StoredSample made = small_recording("flips");
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
  const sample::StoredSample made = small_recording("full");
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
  const sample::StoredSample made = small_recording("eio");
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

TEST_CASE("a lens that cannot be is refused when the recording is opened") {
  sample::StoredSample made = small_recording("lens");
  made.camera.intrinsics = Intrinsics{1e40, 300, 3, 2};
  REQUIRE(sample::record(posix_storage(), made.path, made.camera, made.frames).ok());
  const auto replayed = sample::replay(posix_storage(), made.path);
  CHECK(replayed.ended_with(ErrorCode::Corrupt));
  CHECK(replayed.error->message.find("'fx' is 1e+40") != std::string::npos);
}

TEST_CASE("a disk that refuses to sync or to read is reported") {
  const sample::StoredSample made = small_recording("sync");
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

TEST_CASE("the name of a new recording is on the disk with its first second, however it got it") {
  const std::string folder =
      posix_storage().look_at(sample::scratch_folder("durable_name")).value().real_path;
  const CameraFacts camera = sample::camera(PixelLayout::Mono, 8, 16, 16);
  const auto frames = sample::frames(camera, 31, 1);  // at 29.97 Hz
  for (const Creation how : {Creation::New, Creation::Replace}) {
    FaultyStorage disk(posix_storage(), {.failing_sync = 1});  // the one behind that of the bytes
    auto writer =
        create_recording(disk, folder + (how == Creation::New ? "/new.mkv" : "/x.mkv"), camera, how);
    REQUIRE(writer.ok());
    for (std::size_t i = 0; i < 30; ++i) REQUIRE(writer.value()->append(frames[i]).ok());
    CHECK(disk.syncs() == 0);
    const auto second = writer.value()->append(frames[30]);
    REQUIRE(!second.ok());
    CHECK(second.error().message == "cannot sync '" + folder + "': the disk refused");
  }
}

TEST_CASE("a file system that does not sync folders ends no recording") {
  struct UnsyncedFolder : StorageFile {
    Result<std::size_t> read_at(std::uint64_t, std::span<std::byte>) override { return std::size_t{0}; }
    Result<void> write_at(std::uint64_t, std::span<const std::byte>) override { return {}; }
    Result<std::uint64_t> size() override { return std::uint64_t{0}; }
    Result<void> sync() override { return Error{ErrorCode::Io, "not a folder's", EOPNOTSUPP}; }
  };
  struct UnsyncedFolders : ForwardingStorage {
    using ForwardingStorage::ForwardingStorage;
    Result<std::unique_ptr<StorageFile>> open(const std::string&) override {
      return std::unique_ptr<StorageFile>(std::make_unique<UnsyncedFolder>());
    }
  };
  UnsyncedFolders disk(posix_storage());
  const std::string path = sample::scratch_folder("unsynced_folders") + "/x.mkv";
  const CameraFacts camera = sample::camera(PixelLayout::Mono, 8, 16, 16);
  const auto frames = sample::frames(camera, 40, 1);
  const auto recorded = sample::record(disk, path, camera, frames);
  INFO(sample::error_of(recorded).message);
  CHECK(recorded.ok());
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
                                         "' is not a recording: it is not a Matroska file; 'hdrcam "
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
