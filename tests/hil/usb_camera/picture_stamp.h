// The stamp that the simulated USB camera writes into the top row of every picture: the truth for tests. One
// bit in two pixels, white or black, so that it reads the same from the camera's bytes, from codes after
// conversion to RGB, and from a recording. Value type.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>

#include "hal/core/image.h"

namespace hdrcam::hil {

struct PictureStamp {
  static constexpr std::array<char, 4> kMark{'H', 'D', 'R', 'S'};

  std::array<char, 4> mark = kMark;
  std::uint32_t frame = 0;           // of the sensor, from the start of the stream
  std::uint32_t exposure_100us = 0;  // of this picture
  std::uint16_t gain_16ths = 16;
  std::int16_t brightness = 0;
};
static_assert(sizeof(PictureStamp) == 16);
constexpr int kStampBits = 8 * sizeof(PictureStamp);

inline void write_stamp(const PictureStamp& stamp, std::uint8_t* yuyv) {
  constexpr std::uint8_t kBlack = 16, kWhite = 235;
  const auto bytes = std::bit_cast<std::array<std::uint8_t, sizeof stamp>>(stamp);
  for (int i = 0; i < kStampBits; ++i)
    yuyv[2 * i] = (bytes[static_cast<std::size_t>(i / 8)] >> i % 8 & 1) != 0 ? kWhite : kBlack;
}

// bright(x): whether the pixel in column x of the top row is.
template <class Bright>
std::optional<PictureStamp> read_stamp_bits(Bright&& bright) {
  std::array<std::uint8_t, sizeof(PictureStamp)> bytes{};
  for (int i = 0; i < kStampBits; ++i)
    if (bright(i)) bytes[static_cast<std::size_t>(i / 8)] |= static_cast<std::uint8_t>(1 << i % 8);
  const auto stamp = std::bit_cast<PictureStamp>(bytes);
  return stamp.mark == PictureStamp::kMark ? std::optional(stamp) : std::nullopt;
}

// nullopt where the picture has none, or it is damaged.
inline std::optional<PictureStamp> read_stamp(std::span<const std::byte> yuyv) {
  if (yuyv.size() < 2 * kStampBits) return std::nullopt;
  return read_stamp_bits(
      [&](int x) { return std::to_integer<int>(yuyv[static_cast<std::size_t>(2 * x)]) > 127; });
}
// codes: [rgb, rows, cols], 8 bits.
inline std::optional<PictureStamp> read_stamp(const Image<std::uint16_t>& codes) {
  if (codes.cols() < kStampBits) return std::nullopt;
  return read_stamp_bits([&](int x) { return codes.at(0, 0, x) > 127; });
}

}  // namespace hdrcam::hil
