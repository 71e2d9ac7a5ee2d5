#include "hal/core/counted.h"

#include <catch2/catch.hpp>
#include <cstdint>

namespace hdrcam {

TEST_CASE("one of a thing is said in the singular, any other number in the plural") {
  CHECK(counted(0, "frame") == "0 frames");
  CHECK(counted(1, "frame") == "1 frame");
  CHECK(counted(std::uint64_t{12}, "step") == "12 steps");
  CHECK(counted_per_second(1, "frame") == "1 frame per second");
  CHECK(counted_per_second(1.00001, "frame") == "1 frame per second");
  CHECK(counted_per_second(30000.0 / 1001, "frame") == "29.97 frames per second");
}

}  // namespace hdrcam
