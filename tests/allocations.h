// Counts every call of operator new in the process, on any thread; used to check paths that must not
// allocate. Lets them fail, too, as where memory ends. allocations.cpp replaces the operators of the whole
// test program. Thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>

namespace hdrcam {

std::uint64_t allocations_so_far();
// Of these, the calls from the program's own code, templates of the standard library included, but not those
// inside a shared library, which decides for itself (a codec, a driver).
std::uint64_t own_allocations_so_far();
// false in a build with a sanitizer, whose runtime has its own operators: both counts stay 0 there.
bool allocations_are_counted();

// While it lives, operator new has no memory for this thread's blocks of `refused_bytes` or more; not in a
// build with a sanitizer. One at a time on a thread.
class EndOfMemory {
 public:
  explicit EndOfMemory(std::size_t refused_bytes);
  ~EndOfMemory();
  EndOfMemory(const EndOfMemory&) = delete;
  EndOfMemory& operator=(const EndOfMemory&) = delete;
};

}  // namespace hdrcam
