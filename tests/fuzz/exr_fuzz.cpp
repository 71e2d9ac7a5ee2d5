// An OpenEXR file of anybody.
#include "render/exr.h"

using namespace hdrcam;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto image = decode_exr(std::as_bytes(std::span(data, size)), "x.exr");
  if (image)
    HDRCAM_CHECK_EQ(static_cast<std::size_t>(image.value().samples.channels()), image.value().names.size());
  return 0;
}
