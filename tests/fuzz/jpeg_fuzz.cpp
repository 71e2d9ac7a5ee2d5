// A frame of a camera that sends MJPEG.
#include "hal/jpeg_decoder.h"

using namespace hdrcam;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const DecodeJpeg decode = jpeg_decoder();
  Image<std::uint16_t> rgb(3, 16, 16);
  if (!decode(std::as_bytes(std::span(data, size)), rgb)) return 0;
  for (const std::uint16_t code : rgb.samples()) HDRCAM_CHECK(code <= 255);
  return 0;
}
