#include "capture/white_level.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <catch2/catch.hpp>

using namespace hdrcam;

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

WhiteLevel found_in(const CameraFacts& camera, const std::vector<double>& exposures_s, const Codes& white) {
  WhiteSearch search(camera);
  for (const double exposure_s : exposures_s) search.observe(ramp(camera, exposure_s, white));
  return search.found();
}

void check_near(const WhiteLevel& found, const Codes& expected) {
  for (std::size_t c = 0; c < 3; ++c) CHECK(static_cast<double>(found[c]) == Approx(expected[c]).margin(0.3));
}

}  // namespace

TEST_CASE("where pictures of several exposures clip below the largest code, these codes are white") {
  for (const int bits : {8, 10}) {
    CAPTURE(bits);
    check_near(found_in(camera_of(bits), {1, 4, 0.02}, {240, 240, 240}), {240, 240, 240});
    // white with a cast, as of chroma that was rounded down
    check_near(found_in(camera_of(bits), {0.25, 1}, {252, 255, 250}), {252, 255, 250});
  }
  check_near(found_in(camera_of(8, PixelLayout::Mono), {1, 4}, {200, 0, 0}), {200, 200, 200});
}

TEST_CASE("one exposure that clips shows white where a shorter one tells its pixels apart") {
  const CameraFacts camera = camera_of(8);
  check_near(found_in(camera, {1, 0.02}, {240, 240, 240}), {240, 240, 240});
  CHECK(found_in(camera, {1, 0.0001}, {240, 240, 240}).is_largest_code());  // all but black
}

TEST_CASE("pictures that clip at the largest code, or of one exposure, have no other white") {
  const CameraFacts camera = camera_of(8);
  CHECK(found_in(camera, {1, 4}, {255, 255, 255}).is_largest_code());
  CHECK(found_in(camera, {1, 4}, {254, 254, 254}).is_largest_code());
  CHECK(found_in(camera, {1}, {240, 240, 240}).is_largest_code());
  CHECK(found_in(camera, {1, 1, 1.1}, {240, 240, 240}).is_largest_code());
  CHECK(found_in(camera, {1, 4}, {100, 100, 100}).is_largest_code());  // codes of fewer bits, or a dark scene
  CHECK(found_in(camera, {}, {}).is_largest_code());
}

TEST_CASE("the brightest thing of a scene that is brighter in the longer exposure does not clip") {
  WhiteSearch search(camera_of(8));
  for (const double exposure_s : {1.0, 2.0}) {
    RawFrame wall = ramp(camera_of(8), exposure_s, {0, 0, 0});
    std::ranges::fill(wall.codes.samples(), static_cast<std::uint16_t>(exposure_s > 1 ? 240 : 180));
    search.observe(wall);
  }
  CHECK(search.found().is_largest_code());
}

TEST_CASE("a coloured light, and what is the same in all frames, is not white") {
  const CameraFacts camera = camera_of(8);
  CHECK(found_in(camera, {1, 4}, {255, 255, 0}).is_largest_code());
  CHECK(found_in(camera, {1, 0.02}, {255, 255, 200}).is_largest_code());
  WhiteSearch logo(camera);
  for (const double exposure_s : {0.01, 0.02}) {
    RawFrame frame = ramp(camera, exposure_s, {240, 240, 240});
    for (int c = 0; c < 3; ++c) std::fill_n(frame.codes.plane(c), frame.codes.plane_size() / 10, 200);
    logo.observe(frame);
  }
  CHECK(logo.found().is_largest_code());
}

TEST_CASE("white is not looked for in damaged frames, and codes beyond the stated bits do no harm") {
  WhiteSearch search(camera_of(8));
  for (const double exposure_s : {1.0, 4.0}) {
    RawFrame frame = ramp(camera_of(8), exposure_s, {240, 240, 240});
    frame.facts.flags = kFrameDamaged;
    search.observe(frame);
  }
  CHECK(search.found().is_largest_code());
  CHECK(found_in(camera_of(8), {1, 4}, {4095, 4095, 4095}).is_largest_code());
}

TEST_CASE("white is not looked for in linear codes, mosaics and frames without an exposure") {
  CameraFacts linear = camera_of(12);
  linear.linear = true;
  CHECK(found_in(linear, {1, 4}, {240, 240, 240}).is_largest_code());
  CHECK(found_in(camera_of(12, PixelLayout::BayerRggb), {1, 4}, {240, 240, 240}).is_largest_code());
  WhiteSearch search(camera_of(8));
  for (int i = 0; i < 2; ++i) {
    RawFrame frame = ramp(camera_of(8), 1, {240, 240, 240});
    frame.facts.exposure_s = 0;
    search.observe(frame);
  }
  CHECK(search.found().is_largest_code());
}
