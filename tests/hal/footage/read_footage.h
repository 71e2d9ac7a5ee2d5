// Pictures whose codes are known, as files of several kinds, and what the program reads of such files.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hal/footage/footage.h"
#include "hal/recording/png_image.h"
#include "tests/support/footage_files.h"
#include "tests/support/tiff_directory.h"

#include <catch2/catch.hpp>

namespace hdrcam::test {

// Patches of 16 pixels, every one another colour; pictures differ in their codes.
inline Image<std::uint16_t> patches(int picture, int rows = 64, int cols = 96) {
  Image<std::uint16_t> rgb(3, rows, cols);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < cols; ++x)
        rgb.at(c, y, x) =
            static_cast<std::uint16_t>((37 * (y / 16) + 61 * (x / 16) + 90 * c + 20 * picture) % 256);
  return rgb;
}

inline std::vector<Image<std::uint16_t>> pictures(int count) {
  std::vector<Image<std::uint16_t>> all;
  for (int i = 0; i < count; ++i) all.push_back(patches(i));
  return all;
}

struct ReadFootage {
  CameraFacts camera;
  std::string about;
  std::vector<RawFrame> frames;
  std::vector<FootageLosses> losses;
  std::optional<Error> error;
};

inline ReadFootage read_footage(std::vector<std::string> files, double framerate_hz = 0) {
  ReadFootage all;
  auto footage = open_footage(posix_storage(), std::move(files), framerate_hz);
  if (!footage) return all.error = footage.error(), std::move(all);
  all.camera = footage.value()->camera(), all.about = footage.value()->about();
  for (;;) {
    RawFrame frame;
    const auto more = footage.value()->next(frame);
    if (!more) return all.error = more.error(), std::move(all);
    if (!more.value()) return all.losses = footage.value()->losses(), std::move(all);
    all.frames.push_back(std::move(frame));
  }
}

// The sentence of the error that ended it, which is of this kind.
inline std::string refusal(const ReadFootage& read, ErrorCode code) {
  REQUIRE(read.error);
  CHECK(read.error->code == code);
  return read.error->message;
}

// The largest difference in the middles of the patches, codes of 255.
inline double difference(const RawFrame& frame, int bits, const Image<std::uint16_t>& rgb) {
  const double scale = 255.0 / ((1 << bits) - 1);
  double largest = 0;
  for (int c = 0; c < 3; ++c)
    for (int y = 8; y < rgb.rows(); y += 16)
      for (int x = 8; x < rgb.cols(); x += 16)
        largest = std::max(largest, std::abs(frame.codes.at(c, y, x) * scale - rgb.at(c, y, x)));
  return largest;
}

inline std::string png_file(const std::string& path, const Image<std::uint16_t>& rgb, int bits = 8) {
  REQUIRE(write_png(posix_storage(), path, {bits, rgb.clone()}).ok());
  return path;
}

// Of 16 bits, in one strip, with a unit of resolution as most programs write it. orientation: as EXIF numbers
// it.
inline std::string tiff_file(const std::string& path, const Image<std::uint16_t>& rgb,
                             std::uint16_t orientation = 1) {
  const auto rows = static_cast<std::uint32_t>(rgb.rows()), cols = static_cast<std::uint32_t>(rgb.cols());
  const auto directory = [&](std::uint32_t strip_at) {
    namespace tag = tiff_tag;
    TiffDirectory tags;
    tags.longs(tag::kImageWidth, {cols});
    tags.longs(tag::kImageLength, {rows});
    tags.shorts(tag::kBitsPerSample, {16, 16, 16});
    tags.shorts(tag::kCompression, {1});
    tags.shorts(tag::kPhotometricInterpretation, {2});
    tags.longs(tag::kStripOffsets, {strip_at});
    tags.shorts(tag::kOrientation, {orientation});
    tags.shorts(tag::kSamplesPerPixel, {3});
    tags.longs(tag::kRowsPerStrip, {rows});
    tags.longs(tag::kStripByteCounts, {rows * cols * 6});
    tags.shorts(tag::kResolutionUnit, {2});
    return tags.at(8);
  };
  std::vector<std::uint8_t> bytes{'I', 'I', 42, 0, 8, 0, 0, 0};
  for (const auto byte : directory(static_cast<std::uint32_t>(8 + directory(0).size())))
    bytes.push_back(byte);
  for (int y = 0; y < rgb.rows(); ++y)
    for (int x = 0; x < rgb.cols(); ++x)
      for (int c = 0; c < 3; ++c) TiffDirectory::put(bytes, rgb.at(c, y, x), 2);
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  return path;
}

}  // namespace hdrcam::test
