#include "render/png.h"

#include <png.h>

#include <fmt/format.h>

namespace hdrcam {
namespace {

std::vector<std::uint8_t> interleaved(const Image<std::uint8_t>& picture) {
  const auto channels = static_cast<std::size_t>(picture.channels());
  std::vector<std::uint8_t> pixels(picture.size());
  for (std::size_t c = 0; c < channels; ++c) {
    const std::uint8_t* plane = picture.plane(static_cast<int>(c));
    for (std::size_t i = 0; i < picture.plane_size(); ++i) pixels[i * channels + c] = plane[i];
  }
  return pixels;
}

}  // namespace

Result<std::vector<std::byte>> encode_png(const Image<std::uint8_t>& picture, PngEffort effort) {
  if ((picture.channels() != 1 && picture.channels() != 3) || picture.plane_size() == 0)
    return Error{ErrorCode::Invalid, fmt::format("a PNG holds 1 or 3 channels, not {} of {}x{} pixels",
                                                 picture.channels(), picture.cols(), picture.rows())};
  const std::vector<std::uint8_t> pixels = interleaved(picture);
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(picture.cols());
  header.height = static_cast<png_uint_32>(picture.rows());
  header.format = picture.channels() == 3 ? PNG_FORMAT_RGB : PNG_FORMAT_GRAY;
  header.flags = effort == PngEffort::Fast ? static_cast<png_uint_32>(PNG_IMAGE_FLAG_FAST) : 0u;

  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(header);
  std::vector<std::byte> bytes(size);
  if (png_image_write_to_memory(&header, bytes.data(), &size, 0, pixels.data(), 0, nullptr) == 0)
    return Error{ErrorCode::Io, fmt::format("libpng cannot encode a picture of {}x{} pixels: {}",
                                            picture.cols(), picture.rows(), header.message)};
  bytes.resize(size);
  return bytes;
}

}  // namespace hdrcam
