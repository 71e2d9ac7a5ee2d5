#include "capture/compact_frame.h"

#include <random>

#include "capture/to_exposed_frame.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

RawFrame random_frame(int bits, int channels) {
  RawFrame raw;
  raw.facts.sequence = 17;
  raw.facts.exposure_s = 0.004;
  raw.codes = Image<std::uint16_t>(channels, 9, 14);
  std::mt19937 random(5);
  std::uniform_int_distribution<int> code(0, (1 << bits) - 1);
  for (std::uint16_t& z : raw.codes.samples()) z = static_cast<std::uint16_t>(code(random));
  raw.codes.samples()[0] = static_cast<std::uint16_t>((1 << bits) - 1);
  return raw;
}

ExposedFrame exposed(int bits) {
  ExposedFrame frame;
  REQUIRE(
      to_exposed_frame(random_frame(bits, 3), 3, 1 / 30.0, {.bits = bits, .reference_exposure = 0.002}, frame)
          .ok());
  return frame;
}

void check_same(const ExposedFrame& frame, const ExposedFrame& restored) {
  CHECK(restored.facts.sequence == frame.facts.sequence);
  CHECK(restored.index == frame.index);
  CHECK(restored.exposure == frame.exposure);
  CHECK(restored.reference_exposure == frame.reference_exposure);
  CHECK(restored.interval_s == frame.interval_s);
  CHECK(restored.blur_fraction == frame.blur_fraction);
  REQUIRE(restored.codes.same_shape(frame.codes));
  CHECK(std::ranges::equal(restored.codes.samples(), frame.codes.samples()));
}

}  // namespace

TEST_CASE("a frame waits in one or two bytes a sample and comes back to the bit") {
  for (const int bits : {8, 9, 10, 12, 14, 16}) {
    INFO(bits << " bits");
    const ExposedFrame frame = exposed(bits);
    const CompactFrame waiting(exposed(bits), bits);
    CHECK(waiting.bytes() == frame.codes.size() * (bits <= 8 ? 1 : 2));
    ExposedFrame restored;
    waiting.restore(restored);
    check_same(frame, restored);
  }
}

TEST_CASE("a frame whose codes were already worked on waits as it is") {
  ExposedFrame frame = exposed(8);
  remove_black_level(frame, BlackLevel(4));
  ExposedFrame again = exposed(8);
  remove_black_level(again, BlackLevel(4));
  const CompactFrame waiting(std::move(again), 8);
  CHECK(waiting.bytes() == frame.codes.size() * sizeof(float));
  ExposedFrame restored;
  waiting.restore(restored);
  check_same(frame, restored);
}
