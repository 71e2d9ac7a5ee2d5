// The bytes of a captured buffer: five bytes say format, size and stride, the rest are pixels. Codes stay
// within their bits.
#include "capture/pixel_unpack.h"

using namespace hdrcam;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kHead = 5;
  if (size < kHead) return 0;
  static const DecodeJpeg decode = jpeg_decoder();
  constexpr int kFormats = static_cast<int>(PixelFormat::Bggr12Packed) + 1;
  CapturedBuffer buffer;
  buffer.mode.format = static_cast<PixelFormat>(data[0] % kFormats);
  buffer.mode.width = data[1] % 70;
  buffer.mode.height = data[2] % 70;
  buffer.stride = static_cast<std::size_t>(data[3] | data[4] << 8);
  buffer.pixels = std::as_bytes(std::span(data + kHead, size - kHead));
  Image<std::uint16_t> codes;
  if (!unpack_pixels(buffer, {.yuv_range = {}, .decode_jpeg = decode}, codes)) return 0;
  const int bits = codes_of(buffer.mode.format).bits;
  for (const std::uint16_t code : codes.samples()) HDRCAM_CHECK(code >> bits == 0);
  return 0;
}
