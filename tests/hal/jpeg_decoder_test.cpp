#include "hal/jpeg_decoder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "tests/allocation_checks.h"

#include <jpeglib.h>
#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;

namespace {

using Bytes = std::vector<std::byte>;
constexpr int kCols = 70, kRows = 50;  // no multiple of a block
constexpr std::byte kMarker{0xff}, kSof0{0xc0}, kEnd{0xd9};

struct Encoding {
  int quality = 95;
  int sharing_x = 2, sharing_y = 1;  // pixels of one chroma sample; 2x1 is what USB cameras send
  bool huffman_tables = true, own_tables = false, progressive = false, grey = false;
  int restart_rows = 0;
};

// Smooth, saturated, every channel its own: [rgb, rows, cols].
Image<std::uint16_t> reference_picture(int phase = 0) {
  Image<std::uint16_t> picture(3, kRows, kCols);
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kCols; ++x) {
      const double angle = 2 * std::numbers::pi * (x + phase) / kCols;
      picture.at(0, y, x) = static_cast<std::uint16_t>(x * 255 / kCols);
      picture.at(1, y, x) = static_cast<std::uint16_t>(y * 255 / kRows);
      picture.at(2, y, x) = static_cast<std::uint16_t>(128 + 100 * std::sin(angle));
    }
  return picture;
}

Bytes encoded(const Image<std::uint16_t>& picture, const Encoding& encoding = {}) {
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors{};  // libjpeg's own: ends the test program on an error
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  unsigned char* memory = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&jpeg, &memory, &size);
  jpeg.image_width = static_cast<JDIMENSION>(picture.cols());
  jpeg.image_height = static_cast<JDIMENSION>(picture.rows());
  jpeg.input_components = 3;
  jpeg.in_color_space = JCS_RGB;
  jpeg_set_defaults(&jpeg);
  if (encoding.grey) jpeg_set_colorspace(&jpeg, JCS_GRAYSCALE);
  if (encoding.progressive) jpeg_simple_progression(&jpeg);
  jpeg_set_quality(&jpeg, encoding.quality, TRUE);
  jpeg.comp_info[0].h_samp_factor = encoding.grey ? 1 : encoding.sharing_x;
  jpeg.comp_info[0].v_samp_factor = encoding.grey ? 1 : encoding.sharing_y;
  jpeg.optimize_coding = encoding.own_tables ? TRUE : FALSE;
  jpeg.restart_in_rows = encoding.restart_rows;
  jpeg_start_compress(&jpeg, TRUE);
  if (!encoding.huffman_tables)
    for (int i = 0; i < 2; ++i)
      jpeg.dc_huff_tbl_ptrs[i]->sent_table = jpeg.ac_huff_tbl_ptrs[i]->sent_table = TRUE;
  std::vector<JSAMPLE> line(3 * static_cast<std::size_t>(picture.cols()));
  for (int y = 0; y < picture.rows(); ++y) {
    for (std::size_t i = 0; i < line.size(); ++i)
      line[i] = static_cast<JSAMPLE>(picture.at(static_cast<int>(i % 3), y, static_cast<int>(i / 3)));
    JSAMPROW row = line.data();
    jpeg_write_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_compress(&jpeg);
  jpeg_destroy_compress(&jpeg);
  const auto* first = reinterpret_cast<const std::byte*>(memory);
  const Bytes bytes(first, first + size);
  std::free(memory);
  return bytes;
}

// Where the marker begins; the size where there is none.
std::size_t position(const Bytes& bytes, std::byte marker) {
  const std::array wanted{kMarker, marker};
  return static_cast<std::size_t>(std::search(bytes.begin(), bytes.end(), wanted.begin(), wanted.end()) -
                                  bytes.begin());
}

Image<std::uint16_t> empty_picture() { return {3, kRows, kCols}; }

Image<std::uint16_t> decoded(const DecodeJpeg& decode, const Bytes& bytes) {
  auto rgb = empty_picture();
  const auto done = decode(bytes, rgb);
  INFO((done.ok() ? "" : done.error().message));
  REQUIRE(done.ok());
  return rgb;
}

std::string reason(const DecodeJpeg& decode, const Bytes& bytes) {
  auto rgb = empty_picture();
  const auto done = decode(bytes, rgb);
  REQUIRE_FALSE(done.ok());
  CHECK(done.error().code == ErrorCode::Corrupt);
  return done.error().message;
}

int largest_difference(const Image<std::uint16_t>& a, const Image<std::uint16_t>& b) {
  int largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    largest = std::max(largest, std::abs(a.samples()[i] - b.samples()[i]));
  return largest;
}

bool same(const Image<std::uint16_t>& a, const Image<std::uint16_t>& b) {
  return std::ranges::equal(a.samples(), b.samples());
}

}  // namespace

TEST_CASE("a JPEG decodes to the picture that was encoded") {
  const auto picture = reference_picture();
  const auto decode = jpeg_decoder();
  const Bytes finest = encoded(picture, {.quality = 100, .sharing_x = 1});
  CHECK(largest_difference(decoded(decode, finest), picture) <= 3);
  CHECK(largest_difference(decoded(decode, encoded(picture)), picture) <= 8);
  CHECK(largest_difference(decoded(decode, encoded(picture, {.sharing_y = 2})), picture) <= 8);
}

TEST_CASE("a grey JPEG decodes to three equal channels") {
  const auto rgb = decoded(jpeg_decoder(), encoded(reference_picture(), {.grey = true}));
  CHECK(std::equal(rgb.plane(0), rgb.plane(1), rgb.plane(1)));
  CHECK(std::equal(rgb.plane(1), rgb.plane(2), rgb.plane(2)));
  CHECK(rgb.at(0, kRows - 1, kCols - 1) > rgb.at(0, 0, 0));
}

TEST_CASE("a frame without Huffman tables has those of the standard, whatever the frame before had") {
  constexpr std::byte kTables{0xc4};
  const auto picture = reference_picture();
  const Bytes bare = encoded(picture, {.huffman_tables = false});
  const Bytes own = encoded(reference_picture(9), {.own_tables = true});
  REQUIRE(position(bare, kTables) == bare.size());
  REQUIRE(position(own, kTables) < own.size());
  const auto decode = jpeg_decoder();
  const auto first = decoded(decode, bare);
  CHECK(same(first, decoded(jpeg_decoder(), encoded(picture))));
  static_cast<void>(decoded(decode, own));
  CHECK(same(first, decoded(decode, bare)));
}

TEST_CASE("bytes after the end, a missing end marker and padding before a marker harm nothing") {
  const auto decode = jpeg_decoder();
  const Bytes whole = encoded(reference_picture(), {.restart_rows = 1});
  const auto picture = decoded(decode, whole);
  Bytes longer = whole;
  longer.resize(whole.size() + 500);
  CHECK(same(decoded(decode, longer), picture));
  Bytes endless = whole;
  endless.resize(position(whole, kEnd));
  CHECK(same(decoded(decode, endless), picture));
  constexpr std::byte kRestart2{0xd2};
  Bytes padded = whole;
  REQUIRE(position(whole, kRestart2) < whole.size());
  padded.insert(padded.begin() + static_cast<std::ptrdiff_t>(position(whole, kRestart2)), 2, std::byte{0x55});
  CHECK(same(decoded(decode, padded), picture));
}

TEST_CASE("a frame cut anywhere is refused, or was whole already") {
  const auto decode = jpeg_decoder();
  for (const int restart_rows : {0, 1}) {
    const Bytes whole = encoded(reference_picture(), {.restart_rows = restart_rows});
    const auto picture = decoded(decode, whole);
    std::size_t shortest_whole = whole.size();
    for (std::size_t size = 0; size < whole.size(); ++size) {
      auto rgb = empty_picture();
      const auto done = decode(std::span(whole).first(size), rgb);
      if (!done.ok()) {
        CHECK(done.error().code == ErrorCode::Corrupt);
        continue;
      }
      shortest_whole = std::min(shortest_whole, size);
      CHECK(same(rgb, picture));
    }
    CHECK(shortest_whole + 4 > whole.size());  // only the end marker and a byte of filling can be spared
  }
}

TEST_CASE("what is no JPEG, or no frame of the stream, is refused with the reason") {
  const auto decode = jpeg_decoder();
  CHECK_THAT(reason(decode, {}), Contains("0 bytes"));
  CHECK_THAT(reason(decode, Bytes(100)), Contains("Not a JPEG file"));
  CHECK_THAT(reason(decode, encoded(Image<std::uint16_t>(3, 48, 64))),
             Contains("a JPEG is 64x48 where the stream is 70x50"));
  CHECK_THAT(reason(decode, encoded(reference_picture(), {.progressive = true})), Contains("several scans"));
  Bytes absurd = encoded(reference_picture());
  const std::size_t sizes = position(absurd, kSof0) + 5;  // marker, length, bits; then rows and columns
  std::fill_n(absurd.begin() + static_cast<std::ptrdiff_t>(sizes), 4, std::byte{0xfa});
  CHECK_THAT(reason(decode, absurd), Contains("64250x64250"));
  CHECK(same(decoded(decode, encoded(reference_picture())),
             decoded(jpeg_decoder(), encoded(reference_picture()))));
}

TEST_CASE("damaged frames never harm the decoder, nor the frames after them") {
  const auto decode = jpeg_decoder();
  const Bytes plain = encoded(reference_picture());
  const auto picture = decoded(decode, plain);
  const Bytes kinds[] = {plain, encoded(reference_picture(), {.restart_rows = 1}),
                         encoded(reference_picture(), {.own_tables = true}),
                         encoded(reference_picture(), {.progressive = true}),
                         encoded(reference_picture(), {.huffman_tables = false, .grey = true})};
  std::mt19937 random(20240301);
  const auto pick = [&](std::size_t below) { return random() % below; };
  auto rgb = empty_picture();
  int refused = 0;
  for (int i = 0; i < 3000; ++i) {
    Bytes bytes = kinds[pick(std::size(kinds))];
    const bool header_only = pick(2) == 0;  // where most of the ways to go wrong are
    for (std::size_t flips = 1 + pick(6); flips > 0; --flips)
      bytes[pick(header_only ? std::min<std::size_t>(bytes.size(), 700) : bytes.size())] ^=
          static_cast<std::byte>(1u << pick(8));
    if (pick(4) == 0) bytes.resize(pick(bytes.size()));
    const auto done = decode(bytes, rgb);
    if (done.ok()) continue;
    ++refused;
    REQUIRE(done.error().code == ErrorCode::Corrupt);
    REQUIRE(done.error().message.size() < 300);
  }
  CHECK(refused > 1000);
  CHECK(same(decoded(decode, plain), picture));
}

TEST_CASE("a decoder that has seen a picture allocates nothing for the next") {
  const auto decode = jpeg_decoder();
  const Bytes bytes = encoded(reference_picture());
  auto rgb = empty_picture();
  REQUIRE(decode(bytes, rgb).ok());
  const auto before = allocations_so_far();
  const bool ok = decode(bytes, rgb).ok();
  const auto after = allocations_so_far();
  CHECK(ok);
  CHECK_ALLOCATIONS(after == before);
}
