// How a stored picture becomes upright, as its file states it: by EXIF's orientation (EXIF 2.3, 4.6.4) or by
// the matrix of a video (ISO/IEC 14496-12, 6.2.2). Turns are clockwise. Value types; reentrant.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "hal/core/frame.h"
#include "hal/core/image.h"

namespace hdrcam {

// As EXIF numbers them: what is done to the stored picture, mirroring it left to right first.
enum class Orientation : std::uint8_t {
  Upright = 1,  // nothing
  Mirrored = 2,
  HalfTurn = 3,
  MirroredHalfTurn = 4,          // upside down
  MirroredThreeQuarterTurn = 5,  // rows and columns change places
  QuarterTurn = 6,
  MirroredQuarterTurn = 7,
  ThreeQuarterTurn = 8,
};

// Upright for what is none of EXIF's numbers.
Orientation orientation_of_exif(double number);
// The nine numbers of a video's matrix, row by row, as FFmpeg gives them; only their turn counts, not a
// scale. None: it turns by an angle that is no multiple of 90 degrees, or shears.
std::optional<Orientation> orientation_of_matrix(const std::array<std::int32_t, 9>& matrix);
// As the fields of a whole TIFF, or the EXIF of a whole PNG, state it; Upright where they do not.
Orientation orientation_in_tiff(std::span<const std::uint8_t> file);
Orientation orientation_in_png(std::span<const std::uint8_t> file);

// Whether rows that were read out from top to bottom are still so once the picture is upright.
constexpr bool keeps_order_of_rows(Orientation orientation) {
  return orientation == Orientation::Upright || orientation == Orientation::Mirrored;
}

// "mirrored and turned by 90 degrees"; "not turned".
std::string describe(Orientation orientation);
// Gives a picture the size that one of [rows, cols] has once it is upright.
void reshape_upright(int channels, int rows, int cols, Orientation orientation,
                     Image<std::uint16_t>& upright);

// A plane of a picture as it is stored: [rows, cols], `stride` codes from one row to the next.
struct StoredPlane {
  const std::uint16_t* codes = nullptr;
  std::ptrdiff_t stride = 0;
  int rows = 0, cols = 0;
};

// upright: room for as many codes, rows contiguous, of the size of reshape_upright.
void place_upright(const StoredPlane& stored, Orientation orientation, std::uint16_t* upright);

// The mosaic's pattern once it is upright; rows, cols: as stored. Rgb and Mono stay.
PixelLayout upright_layout(PixelLayout stored, Orientation orientation, int rows, int cols);

}  // namespace hdrcam
