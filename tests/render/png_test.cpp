#include "render/png.h"

#include <png.h>

#include <random>
#include <vector>

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

Image<std::uint8_t> noise(int channels, int rows, int cols) {
  Image<std::uint8_t> picture(channels, rows, cols);
  std::mt19937 random(11);
  for (auto& sample : picture.samples()) sample = static_cast<std::uint8_t>(random() & 255);
  return picture;
}

// Through libpng's own reader: [channels, rows, cols].
Image<std::uint8_t> decoded(const std::vector<std::byte>& bytes) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  REQUIRE(png_image_begin_read_from_memory(&header, bytes.data(), bytes.size()) != 0);
  const int channels = (header.format & PNG_FORMAT_FLAG_COLOR) != 0 ? 3 : 1;
  header.format = channels == 3 ? PNG_FORMAT_RGB : PNG_FORMAT_GRAY;
  std::vector<std::uint8_t> pixels(PNG_IMAGE_SIZE(header));
  REQUIRE(png_image_finish_read(&header, nullptr, pixels.data(), 0, nullptr) != 0);
  Image<std::uint8_t> picture(channels, static_cast<int>(header.height), static_cast<int>(header.width));
  for (std::size_t i = 0; i < pixels.size(); ++i)
    picture.plane(static_cast<int>(
        i % static_cast<std::size_t>(channels)))[i / static_cast<std::size_t>(channels)] = pixels[i];
  return picture;
}

}  // namespace

TEST_CASE("a PNG decodes to the pixels that were encoded, at any effort, shape and size") {
  for (const PngEffort effort : {PngEffort::Fast, PngEffort::Small})
    for (const int channels : {1, 3})
      for (const auto& [rows, cols] : {std::pair{1, 1}, std::pair{7, 13}, std::pair{240, 320}}) {
        const auto picture = noise(channels, rows, cols);
        const auto bytes = encode_png(picture, effort);
        REQUIRE(bytes.ok());
        const auto back = decoded(bytes.value());
        REQUIRE(back.same_shape(picture));
        CHECK(std::equal(picture.samples().begin(), picture.samples().end(), back.samples().begin()));
      }
}

TEST_CASE("a picture that no PNG can hold is an error, not a crash") {
  CHECK(encode_png(Image<std::uint8_t>()).error().code == ErrorCode::Invalid);
  CHECK(encode_png(Image<std::uint8_t>(2, 4, 4)).error().code == ErrorCode::Invalid);
  CHECK(encode_png(Image<std::uint8_t>(3, 0, 4)).error().code == ErrorCode::Invalid);
}
