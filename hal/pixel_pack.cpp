#include "hal/pixel_pack.h"

#include "hal/pixel_format_table.h"

namespace hdrcam {
namespace {

std::byte low(int code) { return static_cast<std::byte>(code & 0xff); }

void pack_rgb(const Image<std::uint16_t>& codes, int y, int first, int last, std::byte* out) {
  const std::uint16_t* a = codes.row(first, y);
  const std::uint16_t* b = codes.row(1, y);
  const std::uint16_t* c = codes.row(last, y);
  for (int x = 0; x < codes.cols(); ++x, out += 3) out[0] = low(a[x]), out[1] = low(b[x]), out[2] = low(c[x]);
}

void pack_words(const std::uint16_t* codes, int cols, std::byte* out) {
  for (int x = 0; x < cols; ++x, out += 2) out[0] = low(codes[x]), out[1] = low(codes[x] >> 8);
}

// MIPI CSI-2: the high bytes of a group of pixels, then their low bits, the first pixel's lowest.
void pack_mipi10(const std::uint16_t* codes, int cols, std::byte* out) {
  for (int x = 0; x + 3 < cols; x += 4, out += 5) {
    int rest = 0;
    for (int k = 0; k < 4; ++k) out[k] = low(codes[x + k] >> 2), rest |= (codes[x + k] & 3) << (2 * k);
    out[4] = low(rest);
  }
}
void pack_mipi12(const std::uint16_t* codes, int cols, std::byte* out) {
  for (int x = 0; x + 1 < cols; x += 2, out += 3) {
    out[0] = low(codes[x] >> 4), out[1] = low(codes[x + 1] >> 4);
    out[2] = low((codes[x] & 15) | (codes[x + 1] & 15) << 4);
  }
}

}  // namespace

std::optional<PackedFormat> packed_format(PixelFormat format) {
  const auto [packing, layout, bits] = packing_of(format);
  if (packing == Packing::Yuyv || packing == Packing::Uyvy || packing == Packing::Nv12 ||
      packing == Packing::Jpeg)
    return std::nullopt;
  return PackedFormat{layout, bits, sharing(packing)};
}

// The first of the list, which has words before what MIPI packs.
std::optional<PixelFormat> format_for(PixelLayout layout, int bits) {
  for (int i = 0; i <= static_cast<int>(PixelFormat::Bggr12Packed); ++i) {
    const auto packed = packed_format(static_cast<PixelFormat>(i));
    if (packed && packed->layout == layout && packed->bits == bits) return static_cast<PixelFormat>(i);
  }
  return std::nullopt;
}

std::size_t packed_stride(PixelFormat format, int width) {
  return row_bytes(packing_of(format).packing, width);
}

void pack_codes(const Image<std::uint16_t>& codes, PixelFormat format, std::span<std::byte> bytes) {
  const std::size_t stride = packed_stride(format, codes.cols());
  HDRCAM_CHECK_EQ(bytes.size(), stride * static_cast<std::size_t>(codes.rows()));
  const Packing packing = packing_of(format).packing;
  for (int y = 0; y < codes.rows(); ++y) {
    std::byte* out = bytes.data() + static_cast<std::size_t>(y) * stride;
    const std::uint16_t* row = codes.row(0, y);
    switch (packing) {
      case Packing::Rgb:
        pack_rgb(codes, y, 0, 2, out);
        break;
      case Packing::Bgr:
        pack_rgb(codes, y, 2, 0, out);
        break;
      case Packing::Words:
        pack_words(row, codes.cols(), out);
        break;
      case Packing::Mipi10:
        pack_mipi10(row, codes.cols(), out);
        break;
      case Packing::Mipi12:
        pack_mipi12(row, codes.cols(), out);
        break;
      case Packing::Bytes:
      case Packing::Yuyv:  // YUV and JPEG are not packed
      case Packing::Uyvy:
      case Packing::Nv12:
      case Packing::Jpeg:
        for (int x = 0; x < codes.cols(); ++x) out[x] = low(row[x]);
        break;
    }
  }
}

}  // namespace hdrcam
