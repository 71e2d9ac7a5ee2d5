#ifdef HDRCAM_HAVE_LIBCAMERA
#include "hal/real/libcamera_formats.h"

#include <algorithm>
#include <iterator>

namespace hdrcam {
namespace {

struct Row {
  PixelFormat format;
  libcamera::PixelFormat theirs;
};
// libcamera names 24-bit formats from the highest bit down: its BGR888 lies in memory as R, G, B.
constexpr Row kRows[] = {
    {PixelFormat::Rgb24, libcamera::formats::BGR888},
    {PixelFormat::Bgr24, libcamera::formats::RGB888},
    {PixelFormat::Yuyv, libcamera::formats::YUYV},
    {PixelFormat::Uyvy, libcamera::formats::UYVY},
    {PixelFormat::Nv12, libcamera::formats::NV12},
    {PixelFormat::Mjpeg, libcamera::formats::MJPEG},
    {PixelFormat::Grey8, libcamera::formats::R8},
    {PixelFormat::Grey10, libcamera::formats::R10},
    {PixelFormat::Grey12, libcamera::formats::R12},
    {PixelFormat::Grey10Packed, libcamera::formats::R10_CSI2P},
    {PixelFormat::Rggb8, libcamera::formats::SRGGB8},
    {PixelFormat::Grbg8, libcamera::formats::SGRBG8},
    {PixelFormat::Gbrg8, libcamera::formats::SGBRG8},
    {PixelFormat::Bggr8, libcamera::formats::SBGGR8},
    {PixelFormat::Rggb10, libcamera::formats::SRGGB10},
    {PixelFormat::Grbg10, libcamera::formats::SGRBG10},
    {PixelFormat::Gbrg10, libcamera::formats::SGBRG10},
    {PixelFormat::Bggr10, libcamera::formats::SBGGR10},
    {PixelFormat::Rggb12, libcamera::formats::SRGGB12},
    {PixelFormat::Grbg12, libcamera::formats::SGRBG12},
    {PixelFormat::Gbrg12, libcamera::formats::SGBRG12},
    {PixelFormat::Bggr12, libcamera::formats::SBGGR12},
    {PixelFormat::Rggb16, libcamera::formats::SRGGB16},
    {PixelFormat::Grbg16, libcamera::formats::SGRBG16},
    {PixelFormat::Gbrg16, libcamera::formats::SGBRG16},
    {PixelFormat::Bggr16, libcamera::formats::SBGGR16},
    {PixelFormat::Rggb10Packed, libcamera::formats::SRGGB10_CSI2P},
    {PixelFormat::Grbg10Packed, libcamera::formats::SGRBG10_CSI2P},
    {PixelFormat::Gbrg10Packed, libcamera::formats::SGBRG10_CSI2P},
    {PixelFormat::Bggr10Packed, libcamera::formats::SBGGR10_CSI2P},
    {PixelFormat::Rggb12Packed, libcamera::formats::SRGGB12_CSI2P},
    {PixelFormat::Grbg12Packed, libcamera::formats::SGRBG12_CSI2P},
    {PixelFormat::Gbrg12Packed, libcamera::formats::SGBRG12_CSI2P},
    {PixelFormat::Bggr12Packed, libcamera::formats::SBGGR12_CSI2P},
};

}  // namespace

libcamera::PixelFormat libcamera_format_of(PixelFormat format) {
  return std::find_if(std::begin(kRows), std::end(kRows),
                      [&](const Row& row) { return row.format == format; })
      ->theirs;
}

std::optional<PixelFormat> format_of(const libcamera::PixelFormat& format) {
  const auto* row =
      std::find_if(std::begin(kRows), std::end(kRows), [&](const Row& r) { return r.theirs == format; });
  if (row == std::end(kRows)) return std::nullopt;
  return row->format;
}

YuvCoding coding_of(const libcamera::ColorSpace& space) {
  using libcamera::ColorSpace;
  YuvCoding yuv;
  yuv.range = space.range == ColorSpace::Range::Full ? YuvRange::Full : YuvRange::Limited;
  switch (space.ycbcrEncoding) {
    case ColorSpace::YcbcrEncoding::None:
    case ColorSpace::YcbcrEncoding::Rec601:
      break;
    case ColorSpace::YcbcrEncoding::Rec709:
      yuv.matrix = YuvMatrix::Bt709;
      break;
    case ColorSpace::YcbcrEncoding::Rec2020:
      yuv.matrix = YuvMatrix::Bt2020;
      break;
  }
  return yuv;
}

}  // namespace hdrcam
#endif
