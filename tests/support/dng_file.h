// Raw still files as cameras leave them: Adobe's Digital Negative 1.4, a TIFF with a mosaic whose codes are
// known.
#pragma once

#include <cstdint>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "tests/support/lossless_jpeg.h"
#include "tests/support/tiff_directory.h"

namespace hdrcam::test {

enum class DngPacking : std::uint16_t { None = 1, LosslessJpeg = 7 };

struct DngStill {
  int rows = 48, cols = 64;
  std::vector<std::uint8_t> pattern{0, 1, 1, 2};  // of the four sites: 0 red, 1 green, 2 blue
  std::uint32_t black = 256, white = 4000;        // codes
  std::vector<std::uint32_t> black_tenths;        // of the four sites; empty: black
  std::uint32_t shutter_per_s = 250;              // the exposure is 1 / so much
  std::uint16_t iso = 400;
  std::uint32_t exposure_index = 0;                      // the sensitivity beyond 16 bits; 0: not stated
  std::vector<std::uint32_t> neutral{1, 2, 1, 1, 2, 3};  // AsShotNeutral, three fractions; empty: none
  std::string date_time, sub_second;                     // of EXIF; "": none
  std::uint16_t focal_35mm_mm = 0;                       // equivalent for 35 mm film; 0: not stated
  std::vector<std::uint32_t> active_area;                // top, left, bottom, right; empty: all
  DngPacking packing = DngPacking::None;
  std::uint16_t orientation = 1;                   // as EXIF numbers them
  std::uint32_t tile_px = 0;                       // side of its tiles; 0: one strip
  std::function<std::uint16_t(int, int)> code_at;  // by row and column
};

// Its strip or its tiles, one after the other; what reaches beyond the mosaic is 0.
inline std::vector<std::vector<std::uint8_t>> parts_of(const DngStill& still) {
  std::vector<std::vector<std::uint8_t>> parts;
  const int tile = static_cast<int>(still.tile_px);
  const int rows = tile > 0 ? tile : still.rows, cols = tile > 0 ? tile : still.cols;
  for (int top = 0; top < still.rows; top += rows)
    for (int left = 0; left < still.cols; left += cols) {
      std::vector<std::uint16_t> codes;
      for (int y = top; y < top + rows; ++y)
        for (int x = left; x < left + cols; ++x)
          codes.push_back(y < still.rows && x < still.cols ? still.code_at(y, x) : std::uint16_t{0});
      std::vector<std::uint8_t>& part = parts.emplace_back();
      if (still.packing == DngPacking::LosslessJpeg)
        part = lossless_jpeg(codes, rows, cols);
      else
        for (const std::uint16_t code : codes) TiffDirectory::put(part, code, 2);
    }
  return parts;
}

// Where the strip or the tiles are.
inline void add_places(const DngStill& still, const std::vector<std::vector<std::uint8_t>>& parts,
                       std::uint32_t mosaic_at, TiffDirectory& dng) {
  std::vector<std::uint32_t> offsets, lengths;
  for (const std::vector<std::uint8_t>& part : parts) {
    offsets.push_back(mosaic_at), lengths.push_back(static_cast<std::uint32_t>(part.size()));
    mosaic_at += lengths.back();
  }
  if (still.tile_px == 0) dng.longs(tiff_tag::kStripOffsets, offsets);
  dng.shorts(tiff_tag::kOrientation, {still.orientation});
  dng.shorts(tiff_tag::kSamplesPerPixel, {1});
  if (still.tile_px == 0) {
    dng.longs(tiff_tag::kRowsPerStrip, {static_cast<std::uint32_t>(still.rows)});
    dng.longs(tiff_tag::kStripByteCounts, lengths);
  } else {
    dng.longs(tiff_tag::kTileWidth, {still.tile_px});
    dng.longs(tiff_tag::kTileLength, {still.tile_px});
    dng.longs(tiff_tag::kTileOffsets, offsets);
    dng.longs(tiff_tag::kTileByteCounts, lengths);
  }
}

inline void add_black_level(const DngStill& still, TiffDirectory& dng) {
  if (still.black_tenths.empty()) return dng.longs(tiff_tag::kBlackLevel, {still.black});
  std::vector<std::uint32_t> fractions;
  for (const std::uint32_t tenths : still.black_tenths) fractions.push_back(tenths), fractions.push_back(10);
  dng.shorts(tiff_tag::kBlackLevelRepeatDim, {2, 2});
  dng.rationals(tiff_tag::kBlackLevel, fractions);
}

inline std::string write_dng(const std::string& path, const DngStill& still) {
  constexpr std::uint16_t kColorFilterArray = 32803;  // a photometric interpretation
  const auto rows = static_cast<std::uint32_t>(still.rows), cols = static_cast<std::uint32_t>(still.cols);
  const std::vector<std::vector<std::uint8_t>> parts = parts_of(still);
  // Offsets of one size whatever they are: the directory is as long with them as without.
  const auto directory = [&](std::uint32_t mosaic_at, std::uint32_t exif_at) {
    TiffDirectory dng;
    dng.longs(tiff_tag::kNewSubfileType, {0});
    dng.longs(tiff_tag::kImageWidth, {cols});
    dng.longs(tiff_tag::kImageLength, {rows});
    dng.shorts(tiff_tag::kBitsPerSample, {16});
    dng.shorts(tiff_tag::kCompression, {static_cast<std::uint16_t>(still.packing)});
    dng.shorts(tiff_tag::kPhotometricInterpretation, {kColorFilterArray});
    dng.text(tiff_tag::kMake, "Maker");
    dng.text(tiff_tag::kModel, "Model");
    add_places(still, parts, mosaic_at, dng);
    dng.shorts(tiff_tag::kCfaRepeatPatternDim, {2, 2});
    dng.bytes(tiff_tag::kCfaPattern, still.pattern);
    dng.longs(tiff_tag::kExifDirectory, {exif_at});
    dng.bytes(tiff_tag::kDngVersion, {1, 4, 0, 0});
    dng.text(tiff_tag::kUniqueCameraModel, "Maker Model");
    add_black_level(still, dng);
    dng.longs(tiff_tag::kWhiteLevel, {still.white});
    dng.signed_rationals(tiff_tag::kColorMatrix1, {1, 1, 0, 1, 0, 1, 0, 1, 1, 1, 0, 1, 0, 1, 0, 1, 1, 1});
    if (!still.neutral.empty()) dng.rationals(tiff_tag::kAsShotNeutral, still.neutral);
    if (!still.active_area.empty()) dng.longs(tiff_tag::kActiveArea, still.active_area);
    return dng.at(8);
  };
  TiffDirectory exif;
  exif.rationals(tiff_tag::kExposureTime, {1, still.shutter_per_s});
  exif.rationals(tiff_tag::kFNumber, {56, 10});
  exif.shorts(tiff_tag::kIsoSpeed, {still.iso});
  if (still.exposure_index > 0) exif.longs(tiff_tag::kRecommendedExposureIndex, {still.exposure_index});
  if (!still.date_time.empty()) exif.text(tiff_tag::kDateTimeOriginal, still.date_time);
  if (!still.sub_second.empty()) exif.text(tiff_tag::kSubSecTimeOriginal, still.sub_second);
  if (still.focal_35mm_mm > 0) exif.shorts(tiff_tag::kFocalLengthIn35mmFilm, {still.focal_35mm_mm});
  const auto exif_at = static_cast<std::uint32_t>(8 + directory(0, 0).size());
  const auto mosaic_at = static_cast<std::uint32_t>(exif_at + exif.at(exif_at).size());
  std::vector<std::uint8_t> bytes{'I', 'I', 42, 0, 8, 0, 0, 0};
  for (const auto byte : directory(mosaic_at, exif_at)) bytes.push_back(byte);
  for (const auto byte : exif.at(exif_at)) bytes.push_back(byte);
  for (const std::vector<std::uint8_t>& part : parts) bytes.insert(bytes.end(), part.begin(), part.end());
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  return path;
}

}  // namespace hdrcam::test
