// Clients that ask for one frame share its file, and only so many frames are held for those that read slowly.
#include "firmware_host/sinks/live_view/held_files.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("a frame's file is shared as long as somebody reads it") {
  HeldFiles files;
  CHECK(files.of(7) == nullptr);
  HttpBody first = http_body("seven");
  files.hold(7, first);
  CHECK(files.of(7) == first);
  CHECK(files.of(8) == nullptr);
  first.reset();
  CHECK(files.of(7) == nullptr);
}

TEST_CASE("no more files of frames are held than fit, until one is read to its end") {
  HeldFiles files;
  std::vector<HttpBody> readers;
  for (std::uint64_t i = 0; i < HeldFiles::kMost; ++i) {
    REQUIRE_FALSE(files.full());
    readers.push_back(http_body(std::string(1, static_cast<char>('a' + i))));
    files.hold(i, readers.back());
  }
  CHECK(files.full());
  CHECK(files.of(2) == readers[2]);
  readers[1].reset();
  REQUIRE_FALSE(files.full());
  const HttpBody another = http_body("another");
  files.hold(9, another);
  CHECK(files.full());
  CHECK(files.of(9) == another);
  CHECK(files.of(0) == readers[0]);
}
