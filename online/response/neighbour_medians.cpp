#include "online/response/neighbour_medians.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace hdrcam {
namespace {

float middle_of(float a, float b, float c) { return std::max(std::min(a, b), std::min(std::max(a, b), c)); }

// Each column of three lines in order, the columns at the border repeated.
class Columns {
 public:
  explicit Columns(int cols) : cols_(static_cast<std::size_t>(cols)) {
    for (std::vector<float>* rank : {&least_, &middle_, &most_}) rank->resize(cols_ + 2);
  }

  void order(const std::array<const float*, 3>& lines) {
    const auto [above, line, below] = lines;
    for (std::size_t x = 0; x < cols_; ++x) {
      const float low = std::min(above[x], line[x]), high = std::max(above[x], line[x]);
      least_[x + 1] = std::min(low, below[x]);
      middle_[x + 1] = std::max(low, std::min(high, below[x]));
      most_[x + 1] = std::max(high, below[x]);
    }
    for (std::vector<float>* rank : {&least_, &middle_, &most_})
      rank->front() = (*rank)[1], rank->back() = (*rank)[cols_];
  }

  // Of nine: the median of the greatest least, the middle middle and the least greatest of three columns.
  void medians(float* out) const {
    for (std::size_t x = 0; x < cols_; ++x)
      out[x] = middle_of(std::max(std::max(least_[x], least_[x + 1]), least_[x + 2]),
                         middle_of(middle_[x], middle_[x + 1], middle_[x + 2]),
                         std::min(std::min(most_[x], most_[x + 1]), most_[x + 2]));
  }

 private:
  std::size_t cols_;
  std::vector<float> least_, middle_, most_;
};

}  // namespace

std::vector<float> neighbour_medians(const Image<float>& codes, int channel, int step) {
  const int rows = codes.rows(), cols = codes.cols(), lines = (rows + step - 1) / step;
  std::vector<float> medians(static_cast<std::size_t>(lines) * static_cast<std::size_t>(cols));
  Columns columns(cols);
  for (int i = 0; i < lines; ++i) {
    const int y = i * step;
    columns.order({codes.row(channel, std::max(0, y - 1)), codes.row(channel, y),
                   codes.row(channel, std::min(rows - 1, y + 1))});
    columns.medians(medians.data() + static_cast<std::size_t>(i) * static_cast<std::size_t>(cols));
  }
  return medians;
}

}  // namespace hdrcam
