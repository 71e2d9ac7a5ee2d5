// Raw still files as cameras leave them: Adobe's Digital Negative 1.4, a TIFF with a mosaic whose codes are
// known.
#pragma once

#include <cstdint>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "tests/support/tiff_directory.h"

namespace hdrcam::test {

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
  std::vector<std::uint32_t> active_area;                // top, left, bottom, right; empty: all
  std::uint32_t tile_px = 0;                             // side of its tiles; 0: one strip
  std::function<std::uint16_t(int, int)> code_at;        // by row and column
};

// The mosaic row by row, or tile by tile; what reaches beyond it is 0.
inline std::vector<std::uint8_t> mosaic_of(const DngStill& still) {
  std::vector<std::uint8_t> bytes;
  const int tile = static_cast<int>(still.tile_px);
  const int rows = tile > 0 ? tile : still.rows, cols = tile > 0 ? tile : still.cols;
  for (int top = 0; top < still.rows; top += rows)
    for (int left = 0; left < still.cols; left += cols)
      for (int y = top; y < top + rows; ++y)
        for (int x = left; x < left + cols; ++x)
          TiffDirectory::put(bytes, y < still.rows && x < still.cols ? still.code_at(y, x) : 0, 2);
  return bytes;
}

// Where the strip or the tiles are.
inline void add_places(const DngStill& still, std::uint32_t mosaic_at, TiffDirectory& dng) {
  const auto rows = static_cast<std::uint32_t>(still.rows), cols = static_cast<std::uint32_t>(still.cols);
  const std::uint32_t tile = still.tile_px;
  if (tile == 0) {
    dng.longs(tiff_tag::kStripOffsets, {mosaic_at});
    dng.shorts(tiff_tag::kSamplesPerPixel, {1});
    dng.longs(tiff_tag::kRowsPerStrip, {rows});
    dng.longs(tiff_tag::kStripByteCounts, {rows * cols * 2});
    return;
  }
  std::vector<std::uint32_t> offsets;
  const std::uint32_t tiles = ((rows + tile - 1) / tile) * ((cols + tile - 1) / tile),
                      bytes = tile * tile * 2;
  for (std::uint32_t i = 0; i < tiles; ++i) offsets.push_back(mosaic_at + i * bytes);
  dng.shorts(tiff_tag::kSamplesPerPixel, {1});
  dng.longs(tiff_tag::kTileWidth, {tile});
  dng.longs(tiff_tag::kTileLength, {tile});
  dng.longs(tiff_tag::kTileOffsets, offsets);
  dng.longs(tiff_tag::kTileByteCounts, std::vector<std::uint32_t>(tiles, bytes));
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
  // Offsets of one size whatever they are: the directory is as long with them as without.
  const auto directory = [&](std::uint32_t mosaic_at, std::uint32_t exif_at) {
    TiffDirectory dng;
    dng.longs(tiff_tag::kNewSubfileType, {0});
    dng.longs(tiff_tag::kImageWidth, {cols});
    dng.longs(tiff_tag::kImageLength, {rows});
    dng.shorts(tiff_tag::kBitsPerSample, {16});
    dng.shorts(tiff_tag::kCompression, {1});
    dng.shorts(tiff_tag::kPhotometricInterpretation, {kColorFilterArray});
    dng.text(tiff_tag::kMake, "Maker");
    dng.text(tiff_tag::kModel, "Model");
    add_places(still, mosaic_at, dng);
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
  const auto mosaic_at = static_cast<std::uint32_t>(8 + directory(0, 0).size());
  const std::vector<std::uint8_t> mosaic = mosaic_of(still);
  const auto exif_at = static_cast<std::uint32_t>(mosaic_at + mosaic.size());
  std::vector<std::uint8_t> bytes{'I', 'I', 42, 0, 8, 0, 0, 0};
  for (const auto byte : directory(mosaic_at, exif_at)) bytes.push_back(byte);
  for (const auto byte : mosaic) bytes.push_back(byte);
  TiffDirectory exif;
  exif.rationals(tiff_tag::kExposureTime, {1, still.shutter_per_s});
  exif.rationals(tiff_tag::kFNumber, {56, 10});
  exif.shorts(tiff_tag::kIsoSpeed, {still.iso});
  if (still.exposure_index > 0) exif.longs(tiff_tag::kRecommendedExposureIndex, {still.exposure_index});
  if (!still.date_time.empty()) exif.text(tiff_tag::kDateTimeOriginal, still.date_time);
  if (!still.sub_second.empty()) exif.text(tiff_tag::kSubSecTimeOriginal, still.sub_second);
  for (const auto byte : exif.at(exif_at)) bytes.push_back(byte);
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  return path;
}

}  // namespace hdrcam::test
