// What the simulated USB camera writes into the first pixels of every picture: the truth that a test compares
// with. Value type.
#pragma once

#include <cstdint>
#include <cstring>
#include <optional>
#include <span>

namespace hdrcam::hil {

struct PictureStamp {
  char mark[4] = {'H', 'D', 'R', 'S'};
  std::uint32_t frame = 0;           // counts from the start of the stream
  std::uint32_t exposure_100us = 0;  // that this picture was taken with
  std::uint16_t gain_16ths = 16;
  std::int16_t brightness = 0;
};
static_assert(sizeof(PictureStamp) == 16);

inline std::optional<PictureStamp> read_stamp(std::span<const std::byte> pixels) {
  PictureStamp stamp;
  if (pixels.size() < sizeof stamp) return std::nullopt;
  const PictureStamp blank;
  std::memcpy(&stamp, pixels.data(), sizeof stamp);
  if (std::memcmp(stamp.mark, blank.mark, sizeof stamp.mark) != 0) return std::nullopt;
  return stamp;
}

}  // namespace hdrcam::hil
