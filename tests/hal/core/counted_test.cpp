#include "hal/core/counted.h"

#include <catch2/catch.hpp>
#include <cstdint>

namespace hdrcam {

TEST_CASE("one of a thing is said in the singular, any other number in the plural") {
  CHECK(counted(0, "frame") == "0 frames");
  CHECK(counted(1, "frame") == "1 frame");
  CHECK(counted(std::uint64_t{12}, "step") == "12 steps");
}

}  // namespace hdrcam
