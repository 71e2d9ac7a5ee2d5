// CHECK_ALLOCATIONS(condition): a CHECK about counted allocations (allocations.h). In a build with a
// sanitizer nothing is counted, and the test reports that it did not check instead of passing silently. The
// test includes Catch2.
#pragma once

#include "tests/allocations.h"

#define CHECK_ALLOCATIONS(...)                                                               \
  do {                                                                                       \
    if (hdrcam::allocations_are_counted())                                                   \
      CHECK(__VA_ARGS__);                                                                    \
    else                                                                                     \
      WARN("not checked, because a sanitizer's build counts no allocations: " #__VA_ARGS__); \
  } while (false)
