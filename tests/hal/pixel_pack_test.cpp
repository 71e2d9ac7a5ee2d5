#include "hal/pixel_pack.h"

#include <vector>

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

std::vector<int> packed(const std::vector<std::uint16_t>& row, PixelFormat format, int channel_count = 1) {
  const int cols = static_cast<int>(row.size()) / channel_count;
  Image<std::uint16_t> codes(channel_count, 1, cols);
  std::copy(row.begin(), row.end(), codes.samples().begin());
  std::vector<std::byte> bytes(packed_stride(format, cols));
  pack_codes(codes, format, bytes);
  std::vector<int> values;
  for (const std::byte b : bytes) values.push_back(std::to_integer<int>(b));
  return values;
}

}  // namespace

TEST_CASE("each format lays its bytes out as its documentation says") {
  CHECK(packed({1, 2, 3, 4, 5, 6}, PixelFormat::Rgb24, 3) == std::vector{1, 3, 5, 2, 4, 6});
  CHECK(packed({1, 2, 3, 4, 5, 6}, PixelFormat::Bgr24, 3) == std::vector{5, 3, 1, 6, 4, 2});
  CHECK(packed({1, 2, 3, 4}, PixelFormat::Gbrg8) == std::vector{1, 2, 3, 4});
  CHECK(packed({0x123, 0xabc}, PixelFormat::Rggb12) == std::vector{0x23, 0x01, 0xbc, 0x0a});
  CHECK(packed({0xfffe, 1}, PixelFormat::Bggr16) == std::vector{0xfe, 0xff, 1, 0});
  // MIPI CSI-2: high bytes, then the low bits, first pixel lowest
  CHECK(packed({0x3ff, 0x001, 0x002, 0x200}, PixelFormat::Rggb10Packed) ==
        std::vector{0xff, 0, 0, 0x80, 0b00'10'01'11});
  CHECK(packed({0xabc, 0x123}, PixelFormat::Grbg12Packed) == std::vector{0xab, 0x12, 0x3c});
}

TEST_CASE("a format is found for the codes of a recording and holds them") {
  for (const PixelLayout layout :
       {PixelLayout::BayerRggb, PixelLayout::BayerGrbg, PixelLayout::BayerGbrg, PixelLayout::BayerBggr})
    for (const int bits : {8, 10, 12, 16}) {
      const auto format = format_for(layout, bits);
      REQUIRE(format);
      CHECK(packed_format(*format)->layout == layout);
      CHECK(packed_format(*format)->bits == bits);
    }
  CHECK(format_for(PixelLayout::Rgb, 8) == PixelFormat::Rgb24);
  CHECK(format_for(PixelLayout::Mono, 8) == PixelFormat::Grey8);
  CHECK(format_for(PixelLayout::Mono, 10) == PixelFormat::Grey10);
  CHECK(format_for(PixelLayout::Mono, 12) == PixelFormat::Grey12);
  CHECK_FALSE(format_for(PixelLayout::Rgb, 12));
  CHECK_FALSE(format_for(PixelLayout::BayerRggb, 9));
  CHECK_FALSE(packed_format(PixelFormat::Mjpeg));
  CHECK_FALSE(packed_format(PixelFormat::Nv12));
  CHECK_FALSE(packed_format(PixelFormat::Uyvy));
}
