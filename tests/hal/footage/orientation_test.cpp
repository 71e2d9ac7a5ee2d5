// Turns and mirrorings that files state, on small pictures.
#include "hal/footage/orientation.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "hal/core/image.h"
#include "tests/support/stored_as.h"
#include "tests/support/tiff_directory.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using test::stored_as;

namespace {

constexpr std::uint16_t kFirst = 1, kLast = 8;  // of EXIF's numbers

Image<std::uint16_t> upright(const Image<std::uint16_t>& stored, Orientation orientation) {
  Image<std::uint16_t> picture;
  reshape_upright(stored.channels(), stored.rows(), stored.cols(), orientation, picture);
  for (int c = 0; c < stored.channels(); ++c)
    place_upright({stored.plane(c), stored.cols(), stored.rows(), stored.cols()}, orientation,
                  picture.plane(c));
  return picture;
}

Image<std::uint16_t> numbered(int rows, int cols) {
  Image<std::uint16_t> picture(1, rows, cols);
  std::uint16_t code = 0;
  for (auto& sample : picture.samples()) sample = ++code;
  return picture;
}

bool are_same(const Image<std::uint16_t>& a, const Image<std::uint16_t>& b) {
  return a.same_shape(b) && std::ranges::equal(a.samples(), b.samples());
}

// In 65536ths; a, b, c and d of x' = a x + c y, y' = b x + d y.
std::array<std::int32_t, 9> display_matrix(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) {
  return {a, b, 0, c, d, 0, 0, 0, 1 << 30};
}

// 0 red, 1 green, 2 blue.
int color_at(PixelLayout layout, int y, int x) {
  const std::pair<PixelLayout, std::array<int, 4>> patterns[] = {{PixelLayout::BayerRggb, {0, 1, 1, 2}},
                                                                 {PixelLayout::BayerGrbg, {1, 0, 2, 1}},
                                                                 {PixelLayout::BayerGbrg, {1, 2, 0, 1}},
                                                                 {PixelLayout::BayerBggr, {2, 1, 1, 0}}};
  for (const auto& [of, colors] : patterns)
    if (of == layout) return colors.at(static_cast<std::size_t>(2 * (y % 2) + x % 2));
  return -1;
}

std::vector<std::uint8_t> tiff_that_states(std::uint16_t orientation) {
  std::vector<std::uint8_t> bytes{'I', 'I', 42, 0, 8, 0, 0, 0};
  test::TiffDirectory fields;
  fields.shorts(test::tiff_tag::kOrientation, {orientation});
  for (const auto byte : fields.at(8)) bytes.push_back(byte);
  return bytes;
}

// A chunk with a checksum that nobody looks at.
void add_chunk(std::vector<std::uint8_t>& png, const std::string& kind,
               const std::vector<std::uint8_t>& content) {
  for (const int shift : {24, 16, 8, 0}) png.push_back(static_cast<std::uint8_t>(content.size() >> shift));
  png.insert(png.end(), kind.begin(), kind.end());
  png.insert(png.end(), content.begin(), content.end());
  png.insert(png.end(), 4, std::uint8_t{0});
}

}  // namespace

TEST_CASE("each of EXIF's orientations is turned upright, whatever the size") {
  for (std::uint16_t number = kFirst; number <= kLast; ++number)
    for (const auto& [rows, cols] : {std::pair(2, 3), {5, 4}, {130, 200}, {1, 70}}) {
      CAPTURE(number, rows, cols);
      const Image<std::uint16_t> picture = numbered(rows, cols);
      CHECK(are_same(upright(stored_as(number, picture), orientation_of_exif(number)), picture));
    }
  Image<std::uint16_t> stored(1, 3, 2);  // its first row is the right column of 1 2 3 above 4 5 6
  std::ranges::copy(std::array<std::uint16_t, 6>{3, 6, 2, 5, 1, 4}, stored.samples().begin());
  CHECK(are_same(upright(stored, Orientation::QuarterTurn), numbered(2, 3)));
}

TEST_CASE("rows keep their order where a picture is as it was stored, or only mirrored left to right") {
  Image<std::uint16_t> stored(1, 2, 2);
  std::ranges::copy(std::array<std::uint16_t, 4>{1, 1, 2, 2}, stored.samples().begin());  // numbers of rows
  for (std::uint16_t number = kFirst; number <= kLast; ++number) {
    CAPTURE(number);
    const Orientation orientation = orientation_of_exif(number);
    CHECK(keeps_order_of_rows(orientation) == are_same(upright(stored, orientation), stored));
  }
}

TEST_CASE("numbers that EXIF does not know turn nothing") {
  for (const double number : {0.0, 9.0, 65535.0, 1e300, -1.0})
    CHECK(orientation_of_exif(number) == Orientation::Upright);
}

TEST_CASE("the matrix of a video turns as EXIF does, whatever its scale, and no other angle is taken") {
  constexpr std::int32_t kOne = 1 << 16;
  const std::array<std::array<std::int32_t, 4>, 8> signs{{{1, 0, 0, 1},
                                                          {-1, 0, 0, 1},
                                                          {-1, 0, 0, -1},
                                                          {1, 0, 0, -1},
                                                          {0, 1, 1, 0},
                                                          {0, 1, -1, 0},
                                                          {0, -1, -1, 0},
                                                          {0, -1, 1, 0}}};
  for (std::uint16_t number = kFirst; number <= kLast; ++number) {
    CAPTURE(number);
    const auto [a, b, c, d] = signs.at(number - 1u);
    const auto stated = orientation_of_exif(number);
    CHECK(orientation_of_matrix(display_matrix(a * kOne, b * kOne, c * kOne, d * kOne)) == stated);
    CHECK(orientation_of_matrix(display_matrix(a * kOne, b * kOne, 2 * c * kOne, 2 * d * kOne)) == stated);
    CHECK(orientation_of_matrix(display_matrix(a * kOne + 1, b * kOne - 1, c * kOne, d * kOne + 1)) ==
          stated);  // rounded
  }
  CHECK(orientation_of_matrix({}) == Orientation::Upright);
  CHECK_FALSE(orientation_of_matrix(display_matrix(56756, 32768, -32768, 56756)));  // by 30 degrees
  CHECK_FALSE(orientation_of_matrix(display_matrix(kOne, kOne / 4, 0, kOne)));      // sheared
}

TEST_CASE("a mosaic that is turned has the pattern of its new first rows") {
  constexpr PixelLayout kPatterns[] = {PixelLayout::BayerRggb, PixelLayout::BayerGrbg, PixelLayout::BayerGbrg,
                                       PixelLayout::BayerBggr};
  for (const PixelLayout stored_pattern : kPatterns)
    for (std::uint16_t number = kFirst; number <= kLast; ++number)
      for (const auto& [rows, cols] : {std::pair(4, 6), {5, 6}, {4, 7}, {5, 7}}) {
        CAPTURE(name(stored_pattern), number, rows, cols);
        Image<std::uint16_t> colors(1, rows, cols);
        for (int y = 0; y < rows; ++y)
          for (int x = 0; x < cols; ++x)
            colors.at(0, y, x) = static_cast<std::uint16_t>(color_at(stored_pattern, y, x));
        const Orientation orientation = orientation_of_exif(number);
        const Image<std::uint16_t> turned = upright(colors, orientation);
        const PixelLayout pattern = upright_layout(stored_pattern, orientation, rows, cols);
        int wrong = 0;
        for (int y = 0; y < turned.rows(); ++y)
          for (int x = 0; x < turned.cols(); ++x) wrong += turned.at(0, y, x) != color_at(pattern, y, x);
        CHECK(wrong == 0);
      }
  CHECK(upright_layout(PixelLayout::Rgb, Orientation::HalfTurn, 4, 6) == PixelLayout::Rgb);
  CHECK(upright_layout(PixelLayout::Mono, Orientation::QuarterTurn, 4, 6) == PixelLayout::Mono);
}

TEST_CASE("a PNG states its orientation in its EXIF, and what is cut or no PNG states none") {
  std::vector<std::uint8_t> png{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  add_chunk(png, "IHDR", std::vector<std::uint8_t>(13));
  const std::size_t head = png.size();
  add_chunk(png, "eXIf", tiff_that_states(6));
  add_chunk(png, "IDAT", tiff_that_states(3));
  CHECK(orientation_in_png(png) == Orientation::QuarterTurn);
  CHECK(orientation_in_tiff(tiff_that_states(6)) == Orientation::QuarterTurn);
  for (std::size_t size = 0; size < head + 8 + 4; ++size)
    CHECK(orientation_in_png(std::span(png).first(size)) == Orientation::Upright);
}
