// Counts every call of operator new in the process, whichever thread makes it: what a path that must not
// allocate is checked with. allocations.cpp replaces the operators of the whole test program. Thread-safe.
#pragma once

#include <cstdint>

namespace hdrcam {

std::uint64_t allocations_so_far();
// Of these, those that the program's own code made, templates of the standard library included: not what a
// shared library does inside its functions (OpenCV's optical flow takes its work space anew for each call).
std::uint64_t own_allocations_so_far();
// false in a build with a sanitizer, whose runtime has operators of its own: both counts stay 0 there.
bool allocations_are_counted();

}  // namespace hdrcam
