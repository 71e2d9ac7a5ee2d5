#include "firmware_host/footage/white_level.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;

namespace {

using Codes = std::array<double, 3>;  // of 255

CameraFacts camera_of(int bits, PixelLayout layout = PixelLayout::Rgb) {
  CameraFacts camera;
  camera.bits = bits, camera.layout = layout;
  return camera;
}

// A ramp, ten times brighter at its end than what clips in an exposure of 1 s; each channel clips at its own
// code.
RawFrame ramp(const CameraFacts& camera, double exposure_s, const Codes& white) {
  constexpr int kRows = 20, kCols = 200;
  RawFrame frame;
  frame.facts.exposure_s = exposure_s;
  frame.codes = Image<std::uint16_t>(channels(camera.layout), kRows, kCols);
  for (int c = 0; c < frame.codes.channels(); ++c)
    for (int y = 0; y < kRows; ++y)
      for (int x = 0; x < kCols; ++x) {
        const double light = std::min(1.0, 10.0 * x / kCols * exposure_s);
        const double code = white[static_cast<std::size_t>(c)] * std::sqrt(light) / 255;
        frame.codes.at(c, y, x) = static_cast<std::uint16_t>(std::lround(code * ((1 << camera.bits) - 1)));
      }
  return frame;
}

std::string warning_of(const CameraFacts& camera, const std::vector<double>& exposures_s,
                       const Codes& white) {
  WhiteLevel level(camera);
  for (const double exposure_s : exposures_s) level.observe(ramp(camera, exposure_s, white));
  return level.warning();
}

}  // namespace

TEST_CASE("pictures of several exposures that clip below the largest code are told of, with the codes") {
  for (const int bits : {8, 10}) {
    CAPTURE(bits);
    CHECK_THAT(warning_of(camera_of(bits), {1, 4, 0.02}, {240, 240, 240}),
               Contains("clip at 240 of 255 in red, 240 in green and 240 in blue, ") &&
                   Contains("(docs/import.md, White level)"));
    // white with a cast, as of chroma that was rounded down
    CHECK_THAT(warning_of(camera_of(bits), {0.25, 1}, {252, 255, 250}),
               Contains("252 of 255 in red, 255 in green and 250 in blue, "));
  }
  CHECK_THAT(warning_of(camera_of(8, PixelLayout::Mono), {1, 4}, {200, 0, 0}),
             Contains("clip at 200 of 255, "));
}

TEST_CASE("pictures that clip at the largest code, or of which one exposure alone clips, are not told of") {
  const CameraFacts camera = camera_of(8);
  CHECK(warning_of(camera, {1, 4}, {255, 255, 255}).empty());
  CHECK(warning_of(camera, {1, 4}, {254, 254, 254}).empty());
  CHECK(warning_of(camera, {1}, {240, 240, 240}).empty());
  CHECK(warning_of(camera, {1, 1, 1.1}, {240, 240, 240}).empty());
  CHECK(warning_of(camera, {1, 0.02}, {240, 240, 240}).empty());
  CHECK(warning_of(camera, {1, 4}, {100, 100, 100}).empty());  // codes of fewer bits, or a dark scene
  CHECK(warning_of(camera, {}, {}).empty());
}

TEST_CASE("the brightest thing of a scene that is brighter in the longer exposure does not clip") {
  WhiteLevel level(camera_of(8));
  for (const double exposure_s : {1.0, 2.0}) {
    RawFrame wall = ramp(camera_of(8), exposure_s, {0, 0, 0});
    std::ranges::fill(wall.codes.samples(), static_cast<std::uint16_t>(exposure_s > 1 ? 240 : 180));
    level.observe(wall);
  }
  CHECK(level.warning().empty());
}

TEST_CASE("linear codes, mosaics and frames without an exposure are not judged") {
  CameraFacts linear = camera_of(12);
  linear.linear = true;
  CHECK(warning_of(linear, {1, 4}, {240, 240, 240}).empty());
  CHECK(warning_of(camera_of(12, PixelLayout::BayerRggb), {1, 4}, {240, 240, 240}).empty());
  WhiteLevel level(camera_of(8));
  for (int i = 0; i < 2; ++i) {
    RawFrame frame = ramp(camera_of(8), 1, {240, 240, 240});
    frame.facts.exposure_s = 0;
    level.observe(frame);
  }
  CHECK(level.warning().empty());
}
