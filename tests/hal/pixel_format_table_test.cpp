#include "hal/pixel_format_table.h"

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

TEST_CASE("raw formats that a flip turns into each other differ in the order of their colours alone") {
  using enum PixelFormat;
  CHECK(alike_but_for_order(Rggb10, Bggr10));
  CHECK(alike_but_for_order(Rggb12Packed, Gbrg12Packed));
  CHECK(alike_but_for_order(Grbg8, Grbg8));
  CHECK_FALSE(alike_but_for_order(Rggb10, Bggr12));
  CHECK_FALSE(alike_but_for_order(Rggb10, Bggr10Packed));
  CHECK_FALSE(alike_but_for_order(Rggb8, Grey8));
  CHECK_FALSE(alike_but_for_order(Rgb24, Bgr24));
  CHECK_FALSE(alike_but_for_order(Yuyv, Yuyv));
}

}  // namespace
}  // namespace hdrcam
