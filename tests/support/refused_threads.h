// While it lives, the system starts no further thread, as at the limit of processes (ulimit -u), which does
// not hold for root: the stack of each would be larger than all addresses. One at a time.
#pragma once

#include <pthread.h>

#include <cstddef>

#include <catch2/catch.hpp>

namespace hdrcam::test {

class RefusedThreads {
 public:
  RefusedThreads() {
    constexpr std::size_t kTooLarge_bytes = std::size_t{1} << 60;
    REQUIRE(pthread_getattr_default_np(&usual_) == 0);
    pthread_attr_t refused;
    REQUIRE(pthread_attr_init(&refused) == 0);
    REQUIRE(pthread_attr_setstacksize(&refused, kTooLarge_bytes) == 0);
    REQUIRE(pthread_setattr_default_np(&refused) == 0);
    pthread_attr_destroy(&refused);
  }
  ~RefusedThreads() {
    pthread_setattr_default_np(&usual_);
    pthread_attr_destroy(&usual_);
  }
  RefusedThreads(const RefusedThreads&) = delete;
  RefusedThreads& operator=(const RefusedThreads&) = delete;

 private:
  pthread_attr_t usual_;
};

}  // namespace hdrcam::test
