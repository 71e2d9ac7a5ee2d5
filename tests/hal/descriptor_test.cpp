// File descriptors that close themselves.
#include "hal/descriptor.h"

#include <fcntl.h>

#include <array>

#include "tests/contracts/expect.h"

namespace hdrcam {
namespace {

bool is_open(int fd) { return ::fcntl(fd, F_GETFD) >= 0; }

TEST_CASE("a descriptor is closed when the last that holds it goes out of scope") {
  std::array<int, 2> ends{};
  REQUIRE(::pipe2(ends.data(), O_CLOEXEC) == 0);
  {
    Descriptor holder;
    CHECK_FALSE(holder.is_open());
    {
      Descriptor first(ends[0]);
      CHECK(first.get() == ends[0]);
      holder = Descriptor(std::move(first));
    }
    CHECK(is_open(ends[0]));
    CHECK(holder.get() == ends[0]);
    holder = Descriptor(ends[1]);
    CHECK_FALSE(is_open(ends[0]));
    CHECK(is_open(ends[1]));
  }
  CHECK_FALSE(is_open(ends[1]));
}

TEST_CASE("what is no descriptor is closed by nobody") {
  const Descriptor refused(::open("/dev/null/none", O_RDONLY | O_CLOEXEC));
  CHECK_FALSE(refused.is_open());
  CHECK(refused.get() < 0);
}

}  // namespace
}  // namespace hdrcam
