#include "hal/footage/orientation.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "hal/core/big_endian.h"
#include "hal/footage/tiff_fields.h"

namespace hdrcam {
namespace {

// Where the code of an upright picture is stored: rows and columns change places first, then counting from
// the end begins.
struct StoredOrder {
  bool across, rows_from_end, cols_from_end;
};

StoredOrder stored_order(Orientation orientation) {
  switch (orientation) {
    case Orientation::Upright:
      break;
    case Orientation::Mirrored:
      return {false, false, true};
    case Orientation::HalfTurn:
      return {false, true, true};
    case Orientation::MirroredHalfTurn:
      return {false, true, false};
    case Orientation::MirroredThreeQuarterTurn:
      return {true, false, false};
    case Orientation::QuarterTurn:
      return {true, true, false};
    case Orientation::MirroredQuarterTurn:
      return {true, true, true};
    case Orientation::ThreeQuarterTurn:
      return {true, false, true};
  }
  return {false, false, false};
}

// By where red is in the first two rows and columns.
constexpr PixelLayout kBayer[2][2] = {{PixelLayout::BayerRggb, PixelLayout::BayerGrbg},
                                      {PixelLayout::BayerGbrg, PixelLayout::BayerBggr}};

}  // namespace

Orientation orientation_of_exif(double number) {
  const bool known = number >= 1 && number < 9;
  return known ? static_cast<Orientation>(static_cast<int>(number)) : Orientation::Upright;
}

// Where x goes and where y goes: x' = a x + c y, y' = b x + d y.
std::optional<Orientation> orientation_of_matrix(const std::array<std::int32_t, 9>& matrix) {
  const double a = matrix[0], b = matrix[1], c = matrix[3], d = matrix[4];
  constexpr double kRounding = 1e-3;  // of the larger ones: a twentieth of a degree
  const auto vanish = [](double x, double y, double beside_x, double beside_y) {
    return std::max(std::abs(x), std::abs(y)) <= kRounding * std::min(std::abs(beside_x), std::abs(beside_y));
  };
  // By which of the two are negative.
  constexpr Orientation kAlong[2][2] = {{Orientation::Upright, Orientation::MirroredHalfTurn},
                                        {Orientation::Mirrored, Orientation::HalfTurn}};
  constexpr Orientation kAcross[2][2] = {{Orientation::MirroredThreeQuarterTurn, Orientation::QuarterTurn},
                                         {Orientation::ThreeQuarterTurn, Orientation::MirroredQuarterTurn}};
  if (vanish(b, c, a, d)) return kAlong[a < 0 ? 1 : 0][d < 0 ? 1 : 0];
  if (vanish(a, d, b, c)) return kAcross[b < 0 ? 1 : 0][c < 0 ? 1 : 0];
  return std::nullopt;
}

Orientation orientation_in_tiff(std::span<const std::uint8_t> file) {
  return orientation_of_exif(TiffFields(file).first_value(TiffTag::Orientation).value_or(1));
}

// PNG, third edition, 5.3 and 11.3.4.5: chunks of a length, a kind, what they hold and a checksum; that of
// EXIF holds a TIFF.
Orientation orientation_in_png(std::span<const std::uint8_t> file) {
  constexpr std::size_t kSignatureBytes = 8, kLengthBytes = 4, kHeadBytes = 8, kChecksumBytes = 4;
  constexpr std::string_view kExif = "eXIf";
  for (std::size_t at = kSignatureBytes; at + kHeadBytes <= file.size();) {
    const std::uint64_t length = big_endian(std::as_bytes(file.subspan(at, kLengthBytes)));
    const auto held = file.subspan(at + kHeadBytes);
    if (length > held.size()) break;
    if (std::ranges::equal(file.subspan(at + kLengthBytes, kExif.size()), kExif))
      return orientation_in_tiff(held.first(length));
    at += kHeadBytes + length + kChecksumBytes;
  }
  return Orientation::Upright;
}

std::string describe(Orientation orientation) {
  switch (orientation) {
    case Orientation::Upright:
      break;
    case Orientation::Mirrored:
      return "mirrored";
    case Orientation::HalfTurn:
      return "turned by 180 degrees";
    case Orientation::MirroredHalfTurn:
      return "mirrored and turned by 180 degrees";
    case Orientation::MirroredThreeQuarterTurn:
      return "mirrored and turned by 270 degrees";
    case Orientation::QuarterTurn:
      return "turned by 90 degrees";
    case Orientation::MirroredQuarterTurn:
      return "mirrored and turned by 90 degrees";
    case Orientation::ThreeQuarterTurn:
      return "turned by 270 degrees";
  }
  return "not turned";
}

void reshape_upright(int channels, int rows, int cols, Orientation orientation,
                     Image<std::uint16_t>& upright) {
  if (stored_order(orientation).across) std::swap(rows, cols);
  upright.reshape(channels, rows, cols);
}

void place_upright(const StoredPlane& stored, Orientation orientation, std::uint16_t* upright) {
  constexpr int kTile = 64;  // sides of the squares that are read and written together, for the caches
  const StoredOrder order = stored_order(orientation);
  const std::ptrdiff_t of_row = order.rows_from_end ? -stored.stride : stored.stride;
  const std::ptrdiff_t of_col = order.cols_from_end ? -1 : 1;
  const std::ptrdiff_t step_y = order.across ? of_col : of_row, step_x = order.across ? of_row : of_col;
  const int rows = order.across ? stored.cols : stored.rows, cols = order.across ? stored.rows : stored.cols;
  const std::uint16_t* const first = stored.codes +
                                     (order.rows_from_end ? (stored.rows - 1) * stored.stride : 0) +
                                     (order.cols_from_end ? stored.cols - 1 : 0);
  const auto place = [&](int y, int left, int right) {
    const std::uint16_t* const from = first + y * step_y;
    std::uint16_t* const to = upright + static_cast<std::ptrdiff_t>(y) * cols;
    if (step_x == 1)
      std::copy(from + left, from + right, to + left);
    else
      for (int x = left; x < right; ++x) to[x] = from[x * step_x];
  };
  for (int top = 0; top < rows; top += kTile)
    for (int left = 0; left < cols; left += kTile)
      for (int y = top; y < std::min(rows, top + kTile); ++y) place(y, left, std::min(cols, left + kTile));
}

PixelLayout upright_layout(PixelLayout stored, Orientation orientation, int rows, int cols) {
  if (!is_bayer(stored)) return stored;
  const StoredOrder order = stored_order(orientation);
  int y = stored == PixelLayout::BayerGbrg || stored == PixelLayout::BayerBggr ? 1 : 0;
  int x = stored == PixelLayout::BayerGrbg || stored == PixelLayout::BayerBggr ? 1 : 0;
  if (order.rows_from_end) y = (rows - 1 + y) % 2;  // as rows - 1 - y
  if (order.cols_from_end) x = (cols - 1 + x) % 2;
  return order.across ? kBayer[x][y] : kBayer[y][x];
}

}  // namespace hdrcam
