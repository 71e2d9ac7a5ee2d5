#include "hal/recording/libav.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("what the FFmpeg libraries cannot do for want of memory is told as of new, and is no bug") {
  char byte = 0;
  CHECK(libav::allocated(&byte) == &byte);
  CHECK_THROWS_AS(libav::allocated<char>(nullptr), std::bad_alloc);
  libav::check_memory(0);
  CHECK_THROWS_AS(libav::check_memory(AVERROR(ENOMEM)), std::bad_alloc);
}
