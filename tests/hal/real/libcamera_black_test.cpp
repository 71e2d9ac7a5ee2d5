#include "hal/real/libcamera_black.h"

#include <array>
#include <cstdint>
#include <optional>

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

std::optional<BlackLevel> stated(const std::array<std::int32_t, 4>& r_gr_gb_b, int bits) {
  return black_level_of(r_gr_gb_b, bits);
}

}  // namespace

TEST_CASE(
    "libcamera's black level of 4096 is the code 64 of 10 bits and 256 of 12, as in the table of sensors") {
  constexpr std::array<std::int32_t, 4> kUsual{4096, 4096, 4096, 4096};
  CHECK(stated(kUsual, 10) == BlackLevel::of_code(64, 10));
  CHECK(stated(kUsual, 12) == BlackLevel::of_code(256, 12));
  CHECK(stated(kUsual, 8) == BlackLevel::of_code(16, 8));
  CHECK(stated(kUsual, 16) == BlackLevel::of_code(4096, 16));
}

TEST_CASE(
    "black levels that differ by colour count as their mean, and none is stated that no code can have") {
  CHECK(stated({4000, 4100, 4120, 4164}, 10) == BlackLevel::of_code(64, 10));
  CHECK(stated({0, 0, 0, 0}, 10) == BlackLevel());
  CHECK_FALSE(stated({-64, -64, -64, -64}, 10));
  CHECK_FALSE(stated({65535, 65535, 65535, 65535}, 16));
  CHECK_FALSE(stated({65535, 65535, 65535, 65535}, 10));
}
