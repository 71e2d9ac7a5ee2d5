#include "tests/allocations.h"

#include <memory>
#include <new>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/not_tested.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("the counter sees every way in which this program allocates, on any thread") {
  if (!allocations_are_counted()) {
    NOT_TESTED("a sanitizer brings operators of its own: no test counts allocations in this build");
    return;
  }
  struct alignas(64) Line {
    char bytes[64];
  };
  // Called directly, the operators cannot be optimised away as a new expression may be.
  const auto counted = [](auto&& allocate, auto&& release) {
    const std::uint64_t all = allocations_so_far(), own = own_allocations_so_far();
    void* memory = allocate();
    const bool seen = allocations_so_far() == all + 1 && own_allocations_so_far() == own + 1;
    release(memory);
    return seen;
  };
  constexpr auto kLine = std::align_val_t(alignof(Line));
  CHECK(counted([] { return ::operator new(24); }, [](void* m) { ::operator delete(m); }));
  CHECK(counted([] { return ::operator new[](24); }, [](void* m) { ::operator delete[](m); }));
  CHECK(counted([] { return ::operator new(24, std::nothrow); }, [](void* m) { ::operator delete(m); }));
  CHECK(counted([] { return ::operator new(sizeof(Line), kLine); },
                [](void* m) { ::operator delete(m, kLine); }));
  CHECK(counted([] { return ::operator new[](sizeof(Line), kLine); },
                [](void* m) { ::operator delete[](m, kLine); }));

  const std::uint64_t before = own_allocations_so_far();
  std::vector<int> numbers(1000);
  numbers[999] = 1;
  CHECK(own_allocations_so_far() > before);
  const std::uint64_t between = own_allocations_so_far();
  std::thread([] { std::make_unique<std::string>(200, 'x')->back() = 'y'; }).join();
  CHECK(own_allocations_so_far() > between);
}

TEST_CASE("where memory is made to end only this thread's large blocks are refused, and only for that time") {
  if (!allocations_are_counted()) {
    NOT_TESTED("a sanitizer brings operators of its own: memory does not end in this build");
    return;
  }
  const auto refused = [](std::size_t bytes) {
    void* const memory = ::operator new(bytes, std::nothrow);
    const bool none = memory == nullptr;
    ::operator delete(memory);
    return none;
  };
  bool here = false, small = true, elsewhere = true;
  std::thread other;
  {
    const EndOfMemory end_of_memory(4096);
    here = refused(4096), small = refused(4095);
    other = std::thread([&] { elsewhere = refused(4096); });
    other.join();
  }
  CHECK(here);
  CHECK_FALSE(small);
  CHECK_FALSE(elsewhere);
  CHECK_FALSE(refused(4096));
}
