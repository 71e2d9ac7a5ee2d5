#include "hal/real/v4l2_formats.h"

#include <linux/media-bus-format.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <iterator>

namespace hdrcam {
namespace {

struct Row {
  PixelFormat format;
  std::uint32_t fourcc, bus_code;
};
// USB cameras call MJPEG MJPG; packed formats have the bus code of their unpacked variant.
constexpr Row kRows[] = {
    {PixelFormat::Rgb24, V4L2_PIX_FMT_RGB24, MEDIA_BUS_FMT_RGB888_1X24},
    {PixelFormat::Bgr24, V4L2_PIX_FMT_BGR24, MEDIA_BUS_FMT_BGR888_1X24},
    {PixelFormat::Yuyv, V4L2_PIX_FMT_YUYV, MEDIA_BUS_FMT_YUYV8_1X16},
    {PixelFormat::Uyvy, V4L2_PIX_FMT_UYVY, MEDIA_BUS_FMT_UYVY8_1X16},
    {PixelFormat::Nv12, V4L2_PIX_FMT_NV12, 0},
    {PixelFormat::Mjpeg, V4L2_PIX_FMT_MJPEG, 0},
    {PixelFormat::Grey8, V4L2_PIX_FMT_GREY, MEDIA_BUS_FMT_Y8_1X8},
    {PixelFormat::Grey10, V4L2_PIX_FMT_Y10, MEDIA_BUS_FMT_Y10_1X10},
    {PixelFormat::Grey12, V4L2_PIX_FMT_Y12, MEDIA_BUS_FMT_Y12_1X12},
    {PixelFormat::Grey10Packed, V4L2_PIX_FMT_Y10P, MEDIA_BUS_FMT_Y10_1X10},
    {PixelFormat::Rggb8, V4L2_PIX_FMT_SRGGB8, MEDIA_BUS_FMT_SRGGB8_1X8},
    {PixelFormat::Grbg8, V4L2_PIX_FMT_SGRBG8, MEDIA_BUS_FMT_SGRBG8_1X8},
    {PixelFormat::Gbrg8, V4L2_PIX_FMT_SGBRG8, MEDIA_BUS_FMT_SGBRG8_1X8},
    {PixelFormat::Bggr8, V4L2_PIX_FMT_SBGGR8, MEDIA_BUS_FMT_SBGGR8_1X8},
    {PixelFormat::Rggb10, V4L2_PIX_FMT_SRGGB10, MEDIA_BUS_FMT_SRGGB10_1X10},
    {PixelFormat::Grbg10, V4L2_PIX_FMT_SGRBG10, MEDIA_BUS_FMT_SGRBG10_1X10},
    {PixelFormat::Gbrg10, V4L2_PIX_FMT_SGBRG10, MEDIA_BUS_FMT_SGBRG10_1X10},
    {PixelFormat::Bggr10, V4L2_PIX_FMT_SBGGR10, MEDIA_BUS_FMT_SBGGR10_1X10},
    {PixelFormat::Rggb12, V4L2_PIX_FMT_SRGGB12, MEDIA_BUS_FMT_SRGGB12_1X12},
    {PixelFormat::Grbg12, V4L2_PIX_FMT_SGRBG12, MEDIA_BUS_FMT_SGRBG12_1X12},
    {PixelFormat::Gbrg12, V4L2_PIX_FMT_SGBRG12, MEDIA_BUS_FMT_SGBRG12_1X12},
    {PixelFormat::Bggr12, V4L2_PIX_FMT_SBGGR12, MEDIA_BUS_FMT_SBGGR12_1X12},
    {PixelFormat::Rggb16, V4L2_PIX_FMT_SRGGB16, MEDIA_BUS_FMT_SRGGB16_1X16},
    {PixelFormat::Grbg16, V4L2_PIX_FMT_SGRBG16, MEDIA_BUS_FMT_SGRBG16_1X16},
    {PixelFormat::Gbrg16, V4L2_PIX_FMT_SGBRG16, MEDIA_BUS_FMT_SGBRG16_1X16},
    {PixelFormat::Bggr16, V4L2_PIX_FMT_SBGGR16, MEDIA_BUS_FMT_SBGGR16_1X16},
    {PixelFormat::Rggb10Packed, V4L2_PIX_FMT_SRGGB10P, MEDIA_BUS_FMT_SRGGB10_1X10},
    {PixelFormat::Grbg10Packed, V4L2_PIX_FMT_SGRBG10P, MEDIA_BUS_FMT_SGRBG10_1X10},
    {PixelFormat::Gbrg10Packed, V4L2_PIX_FMT_SGBRG10P, MEDIA_BUS_FMT_SGBRG10_1X10},
    {PixelFormat::Bggr10Packed, V4L2_PIX_FMT_SBGGR10P, MEDIA_BUS_FMT_SBGGR10_1X10},
    {PixelFormat::Rggb12Packed, V4L2_PIX_FMT_SRGGB12P, MEDIA_BUS_FMT_SRGGB12_1X12},
    {PixelFormat::Grbg12Packed, V4L2_PIX_FMT_SGRBG12P, MEDIA_BUS_FMT_SGRBG12_1X12},
    {PixelFormat::Gbrg12Packed, V4L2_PIX_FMT_SGBRG12P, MEDIA_BUS_FMT_SGBRG12_1X12},
    {PixelFormat::Bggr12Packed, V4L2_PIX_FMT_SBGGR12P, MEDIA_BUS_FMT_SBGGR12_1X12},
};

const Row& row_of(PixelFormat format) {
  return *std::find_if(std::begin(kRows), std::end(kRows),
                       [&](const Row& row) { return row.format == format; });
}

}  // namespace

std::uint32_t fourcc_of(PixelFormat format) { return row_of(format).fourcc; }
std::uint32_t bus_code_of(PixelFormat format) { return row_of(format).bus_code; }

std::optional<PixelFormat> format_of(std::uint32_t fourcc) {
  const auto* row =
      std::find_if(std::begin(kRows), std::end(kRows), [&](const Row& r) { return r.fourcc == fourcc; });
  if (row == std::end(kRows)) return std::nullopt;
  return row->format;
}

std::string fourcc_text(std::uint32_t fourcc) {
  std::string text;
  for (int i = 0; i < 4; ++i) {
    const char letter = static_cast<char>(fourcc >> (8 * i) & 0x7f);
    text += letter < ' ' ? '?' : letter;
  }
  return text;
}

}  // namespace hdrcam
