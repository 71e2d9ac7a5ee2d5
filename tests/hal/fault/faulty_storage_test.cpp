#include "hal/fault/faulty_storage.h"

#include <array>
#include <string_view>

#include "tests/hal/recording/sample_recordings.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

std::span<const std::byte> bytes(std::string_view text) { return std::as_bytes(std::span(text)); }

}  // namespace

TEST_CASE("without faults the disk is the one below") {
  const std::string path = sample::scratch_folder("fault_none") + "/x";
  FaultyStorage disk(posix_storage(), {});
  REQUIRE(write_whole(disk, path, bytes("hello")).ok());
  CHECK(read_whole(posix_storage(), path).value() == "hello");
  CHECK(read_whole(disk, path).value() == "hello");
  CHECK(disk.writes() == 1);
  CHECK(sample::error_of(disk.open(path + "y")).code == ErrorCode::NotFound);
}

TEST_CASE("a full disk takes what fits and refuses the rest; what is rewritten needs no room") {
  const std::string path = sample::scratch_folder("fault_full") + "/x";
  FaultyStorage disk(posix_storage(), {.space_bytes = 8});
  auto file = disk.create(path);
  REQUIRE(file.ok());
  REQUIRE(file.value()->write_at(0, bytes("12345")).ok());
  REQUIRE(file.value()->write_at(0, bytes("abcde")).ok());
  const auto full = file.value()->write_at(5, bytes("67890"));
  REQUIRE(!full.ok());
  CHECK(sample::error_of(full).code == ErrorCode::NoSpace);
  CHECK(full.error().message.find(path) != std::string::npos);
  CHECK(read_whole(posix_storage(), path).value() == "abcde678");
  CHECK(!file.value()->write_at(8, bytes("9")).ok());
}

TEST_CASE("one chosen write, read or sync is refused, the others are not") {
  const std::string path = sample::scratch_folder("fault_nth") + "/x";
  FaultyStorage disk(posix_storage(), {.failing_write = 1, .failing_read = 0, .failing_sync = 1});
  auto file = disk.create(path);
  REQUIRE(file.ok());
  CHECK(file.value()->write_at(0, bytes("a")).ok());
  CHECK(sample::error_of(file.value()->write_at(1, bytes("b"))).code == ErrorCode::Io);
  CHECK(file.value()->write_at(1, bytes("c")).ok());
  CHECK(file.value()->sync().ok());
  CHECK(sample::error_of(file.value()->sync()).code == ErrorCode::Io);
  CHECK(sample::error_of(read_whole(disk, path)).code == ErrorCode::Io);
  CHECK(read_whole(disk, path).value() == "ac");
}

TEST_CASE("a document is on the disk with its name, and a frame of a stream waits for no disk") {
  const std::string path = sample::scratch_folder("fault_durable") + "/x";
  FaultyStorage disk(posix_storage(), {});
  REQUIRE(write_whole(disk, path, bytes("frame"), Durability::WrittenBack).ok());
  CHECK(disk.syncs() == 0);
  REQUIRE(write_whole(disk, path, bytes("document")).ok());
  CHECK(disk.syncs() == 2);  // the file, then the folder that has its name
  FaultyStorage failing(posix_storage(), {.failing_sync = 1});
  CHECK(sample::error_of(write_whole(failing, path, bytes("newer"))).code == ErrorCode::Io);
  CHECK(read_whole(posix_storage(), path).value() == "newer");
}

TEST_CASE("a cut file is short and a flipped bit is flipped, whichever way they are read") {
  const std::string path = sample::scratch_folder("fault_read") + "/x";
  REQUIRE(write_whole(posix_storage(), path, bytes("abcdef")).ok());
  FaultyStorage disk(posix_storage(), {.cut_at_bytes = 4, .flipped_bits = {8, 40}});
  CHECK(read_whole(disk, path).value() == "accd");
  auto file = disk.open(path);
  REQUIRE(file.ok());
  CHECK(file.value()->size().value() == 4);
  std::array<std::byte, 4> some{};
  CHECK(file.value()->read_at(1, some).value() == 3);
  CHECK(some[0] == std::byte{'c'});
  CHECK(file.value()->read_at(4, some).value() == 0);
}
