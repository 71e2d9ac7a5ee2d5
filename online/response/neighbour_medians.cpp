#include "online/response/neighbour_medians.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace hdrcam {
namespace {

// A column of three in order.
struct Column {
  float least, middle, most;
};

Column column_at(const std::array<const float*, 3>& lines, int x) {
  const float a = lines[0][x], b = lines[1][x], c = lines[2][x];
  const float low = std::min(a, b), high = std::max(a, b);
  return {std::min(low, c), std::max(low, std::min(high, c)), std::max(high, c)};
}

float middle_of(float a, float b, float c) { return std::max(std::min(a, b), std::min(std::max(a, b), c)); }

// Of nine: the median of the greatest least, the middle middle and the least greatest of its columns.
float median_of(const Column& a, const Column& b, const Column& c) {
  return middle_of(std::max({a.least, b.least, c.least}), middle_of(a.middle, b.middle, c.middle),
                   std::min({a.most, b.most, c.most}));
}

}  // namespace

std::vector<float> neighbour_medians(const Image<float>& codes, int channel, int step) {
  const int rows = codes.rows(), cols = codes.cols();
  std::vector<float> medians;
  medians.reserve(static_cast<std::size_t>((rows + step - 1) / step) * static_cast<std::size_t>(cols));
  for (int y = 0; y < rows; y += step) {
    const std::array<const float*, 3> lines{codes.row(channel, std::max(0, y - 1)), codes.row(channel, y),
                                            codes.row(channel, std::min(rows - 1, y + 1))};
    Column left = column_at(lines, 0), here = left;
    for (int x = 0; x < cols; ++x) {
      const Column right = column_at(lines, std::min(cols - 1, x + 1));
      medians.push_back(median_of(left, here, right));
      left = here, here = right;
    }
  }
  return medians;
}

}  // namespace hdrcam
