// Pictures as a camera stores them that is held otherwise, for the tests of what turns them upright.
// Reentrant.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "hal/core/image.h"

namespace hdrcam::test {

// Of the upright picture.
enum class PictureSide { Top, Bottom, Left, Right };

// Where the first row and the first column of the stored picture are, by EXIF's number (EXIF 2.3, 4.6.4, A).
struct FirstSides {
  PictureSide row, col;
};
inline FirstSides first_sides(std::uint16_t orientation) {
  using enum PictureSide;
  constexpr std::array<FirstSides, 8> kFirst{{{Top, Left},
                                              {Top, Right},
                                              {Bottom, Right},
                                              {Bottom, Left},
                                              {Left, Top},
                                              {Right, Top},
                                              {Right, Bottom},
                                              {Left, Bottom}}};
  return kFirst.at(static_cast<std::size_t>(orientation - 1));
}

inline Image<std::uint16_t> stored_as(std::uint16_t orientation, const Image<std::uint16_t>& upright) {
  const FirstSides first = first_sides(orientation);
  const auto is_above = [](PictureSide side) {
    return side == PictureSide::Top || side == PictureSide::Bottom;
  };
  const auto away_from = [&](PictureSide side, int y, int x) {
    if (is_above(side)) return side == PictureSide::Top ? y : upright.rows() - 1 - y;
    return side == PictureSide::Left ? x : upright.cols() - 1 - x;
  };
  const bool along = is_above(first.row);
  Image<std::uint16_t> stored(upright.channels(), along ? upright.rows() : upright.cols(),
                              along ? upright.cols() : upright.rows());
  for (int c = 0; c < upright.channels(); ++c)
    for (int y = 0; y < upright.rows(); ++y)
      for (int x = 0; x < upright.cols(); ++x)
        stored.at(c, away_from(first.row, y, x), away_from(first.col, y, x)) = upright.at(c, y, x);
  return stored;
}

}  // namespace hdrcam::test
