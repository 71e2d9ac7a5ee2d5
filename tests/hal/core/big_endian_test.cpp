#include "hal/core/big_endian.h"

#include <array>

#include <catch2/catch.hpp>

using namespace hdrcam;

TEST_CASE("the first of a big-endian number's bytes is the highest, however many there are") {
  constexpr std::array kBytes{std::byte{0x81}, std::byte{0x02}, std::byte{0x03}, std::byte{0x04},
                              std::byte{0x05}, std::byte{0x06}, std::byte{0x07}, std::byte{0xf8}};
  CHECK(big_endian({}) == 0);
  CHECK(big_endian(std::span(kBytes).first(1)) == 0x81);
  CHECK(big_endian(std::span(kBytes).first(4)) == 0x81020304);
  CHECK(big_endian(kBytes) == 0x81020304050607f8);
}
