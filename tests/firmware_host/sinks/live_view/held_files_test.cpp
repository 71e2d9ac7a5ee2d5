// Clients that ask for one picture share it, and only so many are held for those that read slowly.
#include "firmware_host/sinks/live_view/held_files.h"

#include <string>
#include <vector>

#include "tests/contracts/expect.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

Result<HttpBody> share(HeldFiles& files, const FileKey& key, int& encoded) {
  return files.share(key, [&]() -> Result<HttpBody> { return ++encoded, http_body("a picture"); });
}

}  // namespace

TEST_CASE("a frame's file is shared as long as somebody reads it") {
  HeldFiles files(4);
  int encoded = 0;
  HttpBody first = value_of(share(files, {7}, encoded));
  CHECK(value_of(share(files, {7}, encoded)) == first);
  CHECK(encoded == 1);
  CHECK(value_of(share(files, {8}, encoded)) != first);
  CHECK(value_of(share(files, {7, 1.5}, encoded)) != first);
  CHECK(encoded == 3);
  first.reset();
  (void)value_of(share(files, {7}, encoded));
  CHECK(encoded == 4);
}

TEST_CASE("no more files of frames are held than fit, until one is read to its end") {
  constexpr std::size_t kMost = 4;
  HeldFiles files(kMost);
  int encoded = 0;
  std::vector<HttpBody> readers;
  for (std::uint64_t i = 0; i < kMost; ++i) readers.push_back(value_of(share(files, {i}, encoded)));
  for (std::uint64_t i = kMost; i < 64; ++i) {
    const auto refused = share(files, {i}, encoded);
    require_error(refused, ErrorCode::Busy);
    CHECK(refused.error().message == "4 earlier frames are still being read; ask again");
  }
  CHECK(encoded == kMost);
  CHECK(value_of(share(files, {2}, encoded)) == readers[2]);
  readers[1].reset();
  const HttpBody another = value_of(share(files, {9}, encoded));
  require_error(share(files, {10}, encoded), ErrorCode::Busy);
  CHECK(value_of(share(files, {9}, encoded)) == another);
  CHECK(value_of(share(files, {0}, encoded)) == readers[0]);
}

TEST_CASE("large files are held fewer at once, one of any size among them") {
  constexpr std::size_t kMost = 4, kMost_bytes = 1000;
  const auto shared = [](HeldFiles& files, std::uint64_t sequence, std::size_t bytes) {
    return files.share({sequence}, [&] { return Result<HttpBody>(http_body(std::string(bytes, 'x'))); });
  };
  HeldFiles files(kMost, kMost_bytes);
  HttpBody first = value_of(shared(files, 1, 500));
  const HttpBody second = value_of(shared(files, 2, 500));
  const auto refused = shared(files, 3, 500);
  require_error(refused, ErrorCode::Busy);
  CHECK(refused.error().message == "2 earlier frames are still being read; ask again");
  CHECK(value_of(shared(files, 2, 500)) == second);  // takes no further memory
  first.reset();
  CHECK(shared(files, 3, 500).ok());

  HeldFiles of_small(kMost, kMost_bytes);
  std::vector<HttpBody> readers;
  for (std::uint64_t i = 0; i < kMost; ++i) readers.push_back(value_of(shared(of_small, i, 100)));
  require_error(shared(of_small, kMost, 100), ErrorCode::Busy);

  HeldFiles of_huge(kMost, kMost_bytes);
  const HttpBody huge = value_of(shared(of_huge, 1, 5000));
  const auto another = shared(of_huge, 2, 5000);
  require_error(another, ErrorCode::Busy);
  CHECK(another.error().message == "an earlier frame is still being read; ask again");
}

TEST_CASE("a file that is not made is held for nobody") {
  HeldFiles files(1);
  const auto fails = [] { return Result<HttpBody>(Error{ErrorCode::Unsupported, "no encoder"}); };
  require_error(files.share({1}, fails), ErrorCode::Unsupported);
  int encoded = 0;
  CHECK(share(files, {1}, encoded).ok());
}
