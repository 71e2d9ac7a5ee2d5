#include "firmware_host/footage/low_codes.h"

#include <algorithm>
#include <vector>

#include <catch2/catch.hpp>

using namespace hdrcam;
using Catch::Contains;

namespace {

// After frames of a ramp that is clipped at the largest code of so many bits: at the last `clipped` samples.
LowCodes observed(int bits_stated, int bits, int clipped, std::uint16_t brighter = 0) {
  constexpr int kSamples = 2000;
  CameraFacts camera;
  camera.bits = bits_stated;
  LowCodes low(camera);
  const int largest = (1 << bits) - 1;
  for (int frame = 0; frame < 3; ++frame) {
    Image<std::uint16_t> codes(1, 20, kSamples / 20);
    for (int i = 0; i < kSamples; ++i)
      codes.samples()[static_cast<std::size_t>(i)] = static_cast<std::uint16_t>(
          frame == 1 && i >= kSamples - clipped ? largest : i * (largest - 1) / kSamples);
    if (frame == 2 && brighter != 0) codes.samples()[7] = brighter;
    low.observe(codes);
  }
  return low;
}

std::string warning_of(int bits_stated, int bits, int clipped, std::uint16_t brighter = 0) {
  return observed(bits_stated, bits, clipped, brighter).warning();
}

}  // namespace

TEST_CASE("16-bit frames that are clipped at the largest code of fewer bits are told of, with the way up") {
  for (const auto& [bits, way_up] : {std::pair(10, 6), {12, 4}, {14, 2}}) {
    INFO(bits << " bits");
    CHECK(
        warning_of(16, bits, 500) ==
        fmt::format("no code of 16 bits is above {}, and 25 % of frame 1 are at it: codes of {} bits in the "
                    "lower bits of 16 look so, and come out nearly black; shift them up by {} "
                    "(docs/recording.md, Bits)",
                    (1 << bits) - 1, bits, way_up));
  }
}

TEST_CASE("frames of a dark scene, of all 16 bits or of the bits that are stated are not told of") {
  CHECK(warning_of(16, 12, 0).empty());          // dark: nothing at 4095
  CHECK(warning_of(16, 12, 1).empty());          // one sample comes there by chance
  CHECK(warning_of(16, 12, 500, 4096).empty());  // a later code is above it
  CHECK(warning_of(16, 12, 500, 65535).empty());
  CHECK(warning_of(16, 16, 500).empty());
  CHECK(warning_of(16, 8, 500).empty());  // no sensor's codes
  CHECK(warning_of(12, 12, 500).empty());
}

TEST_CASE(
    "of frames that cannot be told apart low codes are suspected, also where a sensor clips below them") {
  CHECK_THAT(observed(16, 12, 0).suspicion(),
             Contains("no code of 16 bits is above 4091") && Contains("those of 12 bits by 4"));
  CHECK(observed(16, 12, 500).suspicion() == warning_of(16, 12, 500));
  CHECK(observed(16, 12, 500, 65535).suspicion().empty());
  CHECK(observed(16, 16, 500).suspicion().empty());
  CHECK(observed(12, 12, 500).suspicion().empty());
}
