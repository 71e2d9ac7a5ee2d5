#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "hal/fault/faulty_storage.h"
#include "hal/forwarding_storage.h"
#include "hal/storage.h"
#include "tests/contracts/storage_contract.h"
#include "tests/support/scratch_folder.h"

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

TEST_CASE("the disk keeps the storage contract") {
  keeps_storage_contract({"posix", posix_storage(), test::scratch_folder("storage")});
}

TEST_CASE("a faulty disk without a fault keeps the storage contract") {
  FaultyStorage storage(posix_storage(), {});
  keeps_storage_contract({"faulty", storage, test::scratch_folder("faulty_storage")});
}

// The disk of a program that looks at a file just before another program writes it.
class LookedTooEarly : public ForwardingStorage {
 public:
  explicit LookedTooEarly(std::string path) : ForwardingStorage(posix_storage()), path_(std::move(path)) {
    missing_ = inner_.look_at(path_).value();
  }
  Result<FileFacts> look_at(const std::string& path) override {
    return path == path_ ? Result<FileFacts>(missing_) : inner_.look_at(path);
  }

 private:
  const std::string path_;
  FileFacts missing_;
};

TEST_CASE("a file that is larger than any picture is not read into memory") {
  const std::string path = test::scratch_folder("too_large") + "/disk.png";
  REQUIRE(write_whole(posix_storage(), path, {}).ok());
  std::filesystem::resize_file(path, (std::uintmax_t{2} << 30) + 1);  // sparse
  const auto refused = read_whole(posix_storage(), path);
  REQUIRE_FALSE(refused.ok());
  CHECK(refused.error().code == ErrorCode::Unsupported);
  CHECK(refused.error().message.find("larger than 2 GiB") != std::string::npos);
  std::filesystem::remove(path);
}

TEST_CASE("of two programs that write one file at the same moment neither loses it") {
  const std::string path = test::scratch_folder("same_moment") + "/file";
  LookedTooEarly storage(path);
  REQUIRE(write_whole(posix_storage(), path, std::as_bytes(std::span("first"))).ok());
  const Result<void> late = write_whole(storage, path, std::as_bytes(std::span("second")));
  REQUIRE_FALSE(late.ok());
  CHECK(late.error().code == ErrorCode::Exists);
  CHECK(late.error().message.find("was written by another program meanwhile; it stays") != std::string::npos);
  CHECK(read_whole(posix_storage(), path).value() == std::string("first", 6));
}

}  // namespace
}  // namespace hdrcam
