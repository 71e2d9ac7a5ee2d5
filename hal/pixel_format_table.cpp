#include "hal/pixel_format_table.h"

namespace hdrcam {
namespace {

// A Bayer format by its place in a group of four.
PixelPacking bayer(PixelFormat format, PixelFormat first, int bits, Packing packing) {
  constexpr PixelLayout kOrders[] = {PixelLayout::BayerRggb, PixelLayout::BayerGrbg, PixelLayout::BayerGbrg,
                                     PixelLayout::BayerBggr};
  return {packing, kOrders[static_cast<int>(format) - static_cast<int>(first)], bits};
}

}  // namespace

PixelPacking packing_of(PixelFormat format) {
  using enum PixelFormat;
  switch (format) {
    case Rgb24:
      return {Packing::Rgb};
    case Bgr24:
      return {Packing::Bgr};
    case Yuyv:
      return {Packing::Yuyv};
    case Uyvy:
      return {Packing::Uyvy};
    case Nv12:
      return {Packing::Nv12};
    case Mjpeg:
      return {Packing::Jpeg};
    case Grey8:
      return {Packing::Bytes, PixelLayout::Mono};
    case Grey10:
      return {Packing::Words, PixelLayout::Mono, 10};
    case Grey12:
      return {Packing::Words, PixelLayout::Mono, 12};
    case Grey10Packed:
      return {Packing::Mipi10, PixelLayout::Mono, 10};
    case Rggb8:
    case Grbg8:
    case Gbrg8:
    case Bggr8:
      return bayer(format, Rggb8, 8, Packing::Bytes);
    case Rggb10:
    case Grbg10:
    case Gbrg10:
    case Bggr10:
      return bayer(format, Rggb10, 10, Packing::Words);
    case Rggb12:
    case Grbg12:
    case Gbrg12:
    case Bggr12:
      return bayer(format, Rggb12, 12, Packing::Words);
    case Rggb16:
    case Grbg16:
    case Gbrg16:
    case Bggr16:
      return bayer(format, Rggb16, 16, Packing::Words);
    case Rggb10Packed:
    case Grbg10Packed:
    case Gbrg10Packed:
    case Bggr10Packed:
      return bayer(format, Rggb10Packed, 10, Packing::Mipi10);
    case Rggb12Packed:
    case Grbg12Packed:
    case Gbrg12Packed:
    case Bggr12Packed:
      return bayer(format, Rggb12Packed, 12, Packing::Mipi12);
  }
  HDRCAM_CHECK_EQ(static_cast<int>(format), -1);  // none of the list
  return {};
}

bool is_raw(PixelFormat format) {
  const PixelPacking packing = packing_of(format);
  return is_bayer(packing.layout) || packing.bits > 8;
}

bool alike_but_for_order(PixelFormat a, PixelFormat b) {
  const PixelPacking of_a = packing_of(a), of_b = packing_of(b);
  return is_bayer(of_a.layout) && is_bayer(of_b.layout) && of_a.packing == of_b.packing &&
         of_a.bits == of_b.bits;
}

std::size_t row_bytes(Packing packing, int width) {
  const auto pixels = static_cast<std::size_t>(width);
  switch (packing) {
    case Packing::Rgb:
    case Packing::Bgr:
      return pixels * 3;
    case Packing::Yuyv:
    case Packing::Uyvy:
    case Packing::Words:
      return pixels * 2;
    case Packing::Mipi10:
      return pixels / 4 * 5;
    case Packing::Mipi12:
      return pixels / 2 * 3;
    case Packing::Nv12:
    case Packing::Bytes:
    case Packing::Jpeg:
      break;
  }
  return pixels;
}

std::size_t picture_bytes(Packing packing, int width, int height, std::size_t stride) {
  const auto rows = static_cast<std::size_t>(packing == Packing::Nv12 ? height + height / 2 : height);
  return stride * (rows - 1) + row_bytes(packing, width);
}

int sharing(Packing packing) {
  if (packing == Packing::Mipi10) return 4;
  const bool yuv = packing == Packing::Yuyv || packing == Packing::Uyvy || packing == Packing::Nv12;
  return yuv || packing == Packing::Mipi12 ? 2 : 1;
}

}  // namespace hdrcam
