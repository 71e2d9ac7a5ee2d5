#include "render/jpeg.h"

#include <cmath>

#include "hal/jpeg_decoder.h"
#include "tests/allocations.h"
#include "tests/contracts/expect.h"
#include "tests/support/not_tested.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

Image<std::uint8_t> noise(int rows, int cols) {
  Image<std::uint8_t> picture(3, rows, cols);
  for (std::size_t i = 0; i < picture.size(); ++i)
    picture.samples()[i] = static_cast<std::uint8_t>(i * 2654435761u >> 24);
  return picture;
}

}  // namespace

TEST_CASE("a picture survives JPEG within a few codes, its channels in their order") {
  Image<std::uint8_t> picture(3, 37, 50);
  for (int y = 0; y < 37; ++y)
    for (int x = 0; x < 50; ++x) {
      picture.at(0, y, x) = static_cast<std::uint8_t>(40 + 4 * x);
      picture.at(1, y, x) = static_cast<std::uint8_t>(220 - 4 * y);
      picture.at(2, y, x) = 90;
    }
  const auto bytes = value_of(encode_jpeg(picture, 95));
  Image<std::uint16_t> decoded(3, 37, 50);
  require_done(jpeg_decoder()(bytes, decoded));
  double squared = 0;
  for (std::size_t i = 0; i < picture.size(); ++i)
    squared += std::pow(static_cast<double>(picture.samples()[i]) - decoded.samples()[i], 2);
  CHECK(std::sqrt(squared / static_cast<double>(picture.size())) < 4);
}

TEST_CASE("a JPEG of less quality is smaller") {
  const Image<std::uint8_t> picture = noise(64, 64);
  CHECK(2 * value_of(encode_jpeg(picture, 30)).size() < value_of(encode_jpeg(picture, 90)).size());
}

TEST_CASE("what is no colour picture is refused as a JPEG") {
  require_error(encode_jpeg(Image<std::uint8_t>(1, 8, 8), 90), ErrorCode::Invalid);
  require_error(encode_jpeg(Image<std::uint8_t>(), 90), ErrorCode::Invalid);
  require_error(encode_jpeg(Image<std::uint8_t>(3, 1, 65501), 90), ErrorCode::Invalid);
}

TEST_CASE("where memory ends while a JPEG grows its encoding is an error, and the next one is whole") {
  if (!allocations_are_counted()) {
    NOT_TESTED("a sanitizer brings operators of its own, and memory cannot be made to end");
    return;
  }
  const Image<std::uint8_t> picture = noise(512, 512);
  const auto whole = value_of(encode_jpeg(picture, 95));
  REQUIRE(whole.size() > 128 << 10);
  const auto encoded_without_memory = [&] {
    const EndOfMemory end_of_memory(128 << 10);
    return encode_jpeg(picture, 95);
  }();
  require_error(encoded_without_memory, ErrorCode::Io);
  CHECK(encoded_without_memory.error().message.find("memory") != std::string::npos);
  CHECK(value_of(encode_jpeg(picture, 95)) == whole);
}
