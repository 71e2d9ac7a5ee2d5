// What a test says that ends early, where this machine or build lacks what it needs. It counts as an
// assertion, because a test without any fails (./run test). Include before Catch2.
#pragma once

#define NOT_TESTED(reason)          \
  do {                              \
    WARN("not tested: " << reason); \
    SUCCEED();                      \
  } while (false)
