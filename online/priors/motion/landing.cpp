#include "online/priors/motion/landing.h"

#include <algorithm>
#include <cmath>

namespace hdrcam {
namespace {

float squared_speed(const Image<float>& cells, int row, int col) {
  const float u = cells.at(0, row, col), v = cells.at(1, row, col);
  return u == kNowhere ? -1 : u * u + v * v;
}

void put(const Image<float>& from, int row, int col, Image<float>& to, int to_row, int to_col) {
  for (int c = 0; c < 2; ++c) to.at(c, to_row, to_col) = from.at(c, row, col);
}

// Where the fastest neighbour of an empty cell is, or the cell itself.
void fill_from_neighbours(const Image<float>& landed, int row, int col, Image<float>& cells) {
  int from_row = row, from_col = col;
  for (int y = std::max(row - 1, 0); y <= std::min(row + 1, landed.rows() - 1); ++y)
    for (int x = std::max(col - 1, 0); x <= std::min(col + 1, landed.cols() - 1); ++x)
      if (squared_speed(landed, y, x) > squared_speed(landed, from_row, from_col)) from_row = y, from_col = x;
  put(landed, from_row, from_col, cells, row, col);
}

}  // namespace

Landing::Landing(int rows, int cols) {
  const auto cells = [](int pixels) { return (pixels + kLandingCell - 1) / kLandingCell; };
  landed_ = Image<float>(2, cells(rows), cells(cols));
  cells_ = Image<float>(2, cells(rows), cells(cols));
}

void Landing::throw_ahead(const std::vector<Mover>& movers, float way, float kept) {
  constexpr float kCells = 1 / static_cast<float>(kLandingCell);
  landed_.fill(kNowhere);
  for (const Mover& mover : movers) {
    const float across = std::floor((mover.x + way * mover.u) * kCells);
    const float down = std::floor((mover.y + way * mover.v) * kCells);
    if (!(across >= 0 && down >= 0 && across < static_cast<float>(cells_.cols()) &&
          down < static_cast<float>(cells_.rows())))
      continue;
    const int row = static_cast<int>(down), col = static_cast<int>(across);
    const float u = kept * mover.u, v = kept * mover.v;
    if (u * u + v * v > squared_speed(landed_, row, col))
      landed_.at(0, row, col) = u, landed_.at(1, row, col) = v;
  }
  cells_.copy_from(landed_);
  if (movers.empty()) return;
  for (int row = 0; row < cells_.rows(); ++row)
    for (int col = 0; col < cells_.cols(); ++col)
      if (landed_.at(0, row, col) == kNowhere) fill_from_neighbours(landed_, row, col, cells_);
}

}  // namespace hdrcam
