#include "hal/footage/tiff_objection.h"

#include <fmt/format.h>

#include <fstream>
#include <span>
#include <utility>
#include <vector>

#include "hal/footage/footage.h"
#include "tests/hal/recording/sample_recordings.h"
#include "tests/support/tiff_directory.h"

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;
namespace tag = test::tiff_tag;

namespace {

struct TiffKind {
  std::uint32_t subfile = 0, tile_px = 0, picture_at = 0;  // 0: not stated
  std::uint16_t bits = 16, compression = 1, colors = 2, sample_format = 1;
};

// A picture of 16x16 pixels of three samples, with room for two bytes of each.
std::vector<std::uint8_t> tiff_of(const TiffKind& kind) {
  constexpr std::uint32_t kSide = 16, kBytes = kSide * kSide * 6;
  const auto directory = [&](std::uint32_t pixels_at) {
    test::TiffDirectory tags;
    tags.longs(tag::kNewSubfileType, {kind.subfile});
    tags.longs(tag::kImageWidth, {kSide});
    tags.longs(tag::kImageLength, {kSide});
    tags.shorts(tag::kBitsPerSample, {kind.bits, kind.bits, kind.bits});
    tags.shorts(tag::kCompression, {kind.compression});
    tags.shorts(tag::kPhotometricInterpretation, {kind.colors});
    if (kind.tile_px == 0) tags.longs(tag::kStripOffsets, {pixels_at});
    tags.shorts(tag::kSamplesPerPixel, {3});
    if (kind.tile_px == 0)
      tags.longs(tag::kRowsPerStrip, {kSide}), tags.longs(tag::kStripByteCounts, {kBytes});
    if (kind.tile_px > 0) {
      tags.longs(tag::kTileWidth, {kind.tile_px});
      tags.longs(tag::kTileLength, {kind.tile_px});
      tags.longs(tag::kTileOffsets, {pixels_at});
      tags.longs(tag::kTileByteCounts, {kBytes});
    }
    if (kind.picture_at > 0) tags.longs(tag::kSubIfds, {kind.picture_at});
    tags.shorts(tag::kSampleFormat, {kind.sample_format, kind.sample_format, kind.sample_format});
    return tags.at(8);
  };
  std::vector<std::uint8_t> bytes{'I', 'I', 42, 0, 8, 0, 0, 0};
  for (const auto byte : directory(static_cast<std::uint32_t>(8 + directory(0).size())))
    bytes.push_back(byte);
  for (std::uint32_t i = 0; i < kBytes; ++i) bytes.push_back(static_cast<std::uint8_t>(i * 7));
  return bytes;
}

std::string objection_to_kind(const TiffKind& kind) { return objection_to_tiff(tiff_of(kind)).value_or(""); }

}  // namespace

TEST_CASE("a TIFF whose codes FFmpeg would take wrongly is refused, and it is said why") {
  CHECK(objection_to_kind({}) == "");
  CHECK_THAT(objection_to_kind({.tile_px = 16}), Contains("in tiles") && Contains("convert it to PNG"));
  CHECK_THAT(objection_to_kind({.compression = 7}), Contains("JPEG inside"));
  CHECK_THAT(objection_to_kind({.sample_format = 3}), Contains("floating point"));
  CHECK_THAT(objection_to_kind({.sample_format = 2}), Contains("sample format 2"));
  CHECK_THAT(objection_to_kind({.colors = 6}), Contains("YCbCr"));
  CHECK_THAT(objection_to_kind({.bits = 16, .colors = 5}), Contains("CMYK"));
  CHECK(objection_to_kind({.bits = 8, .colors = 5}) == "");  // becomes RGB
}

TEST_CASE("a preview in front of a TIFF's picture is not taken for the picture") {
  CHECK_THAT(objection_to_kind({.subfile = 1}), Contains("begins with a preview"));
  const auto picture_at = static_cast<std::uint32_t>(tiff_of({.subfile = 1, .picture_at = 1}).size());
  std::vector<std::uint8_t> preview = tiff_of({.subfile = 1, .picture_at = picture_at});
  test::TiffDirectory picture;
  picture.longs(tag::kTileWidth, {16});
  for (const auto byte : picture.at(picture_at)) preview.push_back(byte);
  CHECK_THAT(objection_to_tiff(preview).value_or(""), Contains("in tiles"));
}

TEST_CASE("what is no TIFF, or was cut, is left to the decoder, and nothing behind its end is read") {
  const std::vector<std::uint8_t> whole = tiff_of({.tile_px = 16});
  const std::vector<std::uint8_t> text{'n', 'o', ' ', 'T', 'I', 'F', 'F', ',', 0, 0};
  CHECK_FALSE(objection_to_tiff(text));
  for (std::size_t bytes = 0; bytes < 120; ++bytes) objection_to_tiff(std::span(whole).first(bytes));
  CHECK_FALSE(objection_to_tiff(std::span(whole).first(40)));
}

TEST_CASE("footage of a TIFF in tiles, or with samples of floating point, ends with an error that names it") {
  const std::string folder = sample::scratch_folder("footage_tiff_kinds");
  for (const auto& [name, kind] :
       {std::pair{"tiles", TiffKind{.tile_px = 16}}, std::pair{"half", TiffKind{.sample_format = 3}}}) {
    const std::string path = fmt::format("{}/{}.tif", folder, name);
    const std::vector<std::uint8_t> bytes = tiff_of(kind);
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    const Error refused = sample::error_of(open_footage(posix_storage(), {path}, 0));
    CHECK(refused.code == ErrorCode::Unsupported);
    CHECK_THAT(refused.message, Contains(path) && Contains("is a TIFF"));
  }
}
