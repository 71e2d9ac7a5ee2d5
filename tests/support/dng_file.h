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
  std::uint32_t shutter_per_s = 250;              // the exposure is 1 / so much
  std::uint16_t iso = 400;
  std::vector<std::uint32_t> neutral{1, 2, 1, 1, 2, 3};  // AsShotNeutral, three fractions; empty: none
  std::string date_time, sub_second;                     // of EXIF; "": none
  std::vector<std::uint32_t> active_area;                // top, left, bottom, right; empty: all
  std::function<std::uint16_t(int, int)> code_at;        // by row and column
};

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
    dng.longs(tiff_tag::kStripOffsets, {mosaic_at});
    dng.shorts(tiff_tag::kSamplesPerPixel, {1});
    dng.longs(tiff_tag::kRowsPerStrip, {rows});
    dng.longs(tiff_tag::kStripByteCounts, {rows * cols * 2});
    dng.shorts(tiff_tag::kCfaRepeatPatternDim, {2, 2});
    dng.bytes(tiff_tag::kCfaPattern, still.pattern);
    dng.longs(tiff_tag::kExifDirectory, {exif_at});
    dng.bytes(tiff_tag::kDngVersion, {1, 4, 0, 0});
    dng.text(tiff_tag::kUniqueCameraModel, "Maker Model");
    dng.longs(tiff_tag::kBlackLevel, {still.black});
    dng.longs(tiff_tag::kWhiteLevel, {still.white});
    dng.signed_rationals(tiff_tag::kColorMatrix1, {1, 1, 0, 1, 0, 1, 0, 1, 1, 1, 0, 1, 0, 1, 0, 1, 1, 1});
    if (!still.neutral.empty()) dng.rationals(tiff_tag::kAsShotNeutral, still.neutral);
    if (!still.active_area.empty()) dng.longs(tiff_tag::kActiveArea, still.active_area);
    return dng.at(8);
  };
  const auto mosaic_at = static_cast<std::uint32_t>(8 + directory(0, 0).size());
  const std::uint32_t exif_at = mosaic_at + rows * cols * 2;
  std::vector<std::uint8_t> bytes{'I', 'I', 42, 0, 8, 0, 0, 0};
  for (const auto byte : directory(mosaic_at, exif_at)) bytes.push_back(byte);
  for (int y = 0; y < still.rows; ++y)
    for (int x = 0; x < still.cols; ++x) TiffDirectory::put(bytes, still.code_at(y, x), 2);
  TiffDirectory exif;
  exif.rationals(tiff_tag::kExposureTime, {1, still.shutter_per_s});
  exif.rationals(tiff_tag::kFNumber, {56, 10});
  exif.shorts(tiff_tag::kIsoSpeed, {still.iso});
  if (!still.date_time.empty()) exif.text(tiff_tag::kDateTimeOriginal, still.date_time);
  if (!still.sub_second.empty()) exif.text(tiff_tag::kSubSecTimeOriginal, still.sub_second);
  for (const auto byte : exif.at(exif_at)) bytes.push_back(byte);
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  return path;
}

}  // namespace hdrcam::test
