// Counts every call of operator new in the process, on any thread; used to check paths that must not
// allocate. allocations.cpp replaces the operators of the whole test program. Thread-safe.
#pragma once

#include <cstdint>

namespace hdrcam {

std::uint64_t allocations_so_far();
// Of these, the calls from the program's own code, templates of the standard library included, but not those
// inside a shared library, which decides for itself (a codec, a driver).
std::uint64_t own_allocations_so_far();
// false in a build with a sanitizer, whose runtime has its own operators: both counts stay 0 there.
bool allocations_are_counted();

}  // namespace hdrcam
