#include "hal/video/light_level.h"

#include <algorithm>

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes patched(Bytes header, const LightLevel& stated, const LightLevel& level) {
  for (const BytePatch& patch : light_level_patches(header, stated, level))
    std::copy(patch.bytes.begin(), patch.bytes.end(),
              header.begin() + static_cast<std::ptrdiff_t>(patch.offset));
  return header;
}

}  // namespace

TEST_CASE("the measured light level replaces the stated one in the box and in the elements") {
  const Bytes header{9,    'c',  'l', 'l',  'i',  3, 0xe8, 3,    0xe8, 7, 0x55,
                     0xbc, 0x82, 3,   0xe8, 0x55, 1, 0x55, 0xbd, 0x82, 3, 0xe8};
  const Bytes expected{9,    'c',  'l', 'l', 'i',  2, 1,    0,    77,   7, 0x55,
                       0xbc, 0x82, 2,   1,   0x55, 1, 0x55, 0xbd, 0x82, 0, 77};
  CHECK(patched(header, {1000, 1000}, {513, 77}) == expected);
}

TEST_CASE("a number that Matroska wrote in one byte stays one byte") {
  const Bytes header{0x55, 0xbc, 0x81, 200, 0x55, 0xbd, 0x81, 200};
  CHECK(patched(header, {200, 200}, {150, 9}) == Bytes{0x55, 0xbc, 0x81, 150, 0x55, 0xbd, 0x81, 9});
}

TEST_CASE("a header that states no light level is left alone") {
  CHECK(light_level_patches(Bytes{1, 2, 3, 4, 5, 6, 7, 8}, {1000, 1000}, {500, 50}).empty());
}
