// CHECK_ALLOCATIONS(condition): a CHECK about counted allocations (allocations.h). In a build with a
// sanitizer nothing is counted, and the test says that it did not look instead of passing for nothing. Catch2
// is included by the test.
#pragma once

#include "tests/allocations.h"

#define CHECK_ALLOCATIONS(...)                                                               \
  do {                                                                                       \
    if (hdrcam::allocations_are_counted())                                                   \
      CHECK(__VA_ARGS__);                                                                    \
    else                                                                                     \
      WARN("not checked, because a sanitizer's build counts no allocations: " #__VA_ARGS__); \
  } while (false)
