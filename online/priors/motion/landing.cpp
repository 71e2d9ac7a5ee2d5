#include "online/priors/motion/landing.h"

#include <algorithm>

namespace hdrcam {
namespace {

float squared_speed(const Image<float>& cells, int row, int col) {
  const float u = cells.at(0, row, col), v = cells.at(1, row, col);
  return u == kNowhere ? -1 : u * u + v * v;
}

void put(const Image<float>& from, int row, int col, Image<float>& to, int to_row, int to_col) {
  for (int c = 0; c < 2; ++c) to.at(c, to_row, to_col) = from.at(c, row, col);
}

// An empty cell gets the motion of its fastest neighbour; it stays empty where all of them are.
void fill_from_neighbours(const Image<float>& landed, int row, int col, Image<float>& cells) {
  int from_row = row, from_col = col;
  for (int y = std::max(row - 1, 0); y <= std::min(row + 1, landed.rows() - 1); ++y)
    for (int x = std::max(col - 1, 0); x <= std::min(col + 1, landed.cols() - 1); ++x)
      if (squared_speed(landed, y, x) > squared_speed(landed, from_row, from_col)) from_row = y, from_col = x;
  put(landed, from_row, from_col, cells, row, col);
}

// Whether a motion leads to a pixel whose motion leads back.
bool comes_home(float x, float y, float u, float v, const Image<float>& back) {
  const float to_x = x + u + 0.5f, to_y = y + v + 0.5f;  // cut to whole numbers: the nearest pixel
  if (!(to_x >= 0 && to_y >= 0 && to_x < static_cast<float>(back.cols()) &&
        to_y < static_cast<float>(back.rows())))
    return false;
  const int row = static_cast<int>(to_y), col = static_cast<int>(to_x);
  const float du = u + back.at(0, row, col), dv = v + back.at(1, row, col);
  return du * du + dv * dv <= kHome2;
}

// The motion of a pixel at this place goes to the cell there, if it is faster than what came before.
void land(float x, float y, float u, float v, Image<float>& cells) {
  constexpr float kCells = 1 / static_cast<float>(kLandingCell);
  const float across = x * kCells, down = y * kCells;
  if (!(across >= 0 && down >= 0 && across < static_cast<float>(cells.cols()) &&
        down < static_cast<float>(cells.rows())))
    return;
  const int row = static_cast<int>(down), col = static_cast<int>(across);
  if (u * u + v * v > squared_speed(cells, row, col)) cells.at(0, row, col) = u, cells.at(1, row, col) = v;
}

}  // namespace

Landing::Landing(int rows, int cols) {
  landed_ = Image<float>(2, landing_cells(rows), landing_cells(cols));
  cells_ = Image<float>(2, landing_cells(rows), landing_cells(cols));
}

void Landing::throw_ahead(const Image<float>& there, const Image<float>& back, float least, float share) {
  constexpr int kEvery = 2;  // pixels: one of four is enough for a cell
  landed_.fill(kNowhere);
  bool any = false;
  for (int row = 0; row < there.rows(); row += kEvery) {
    const float *us = there.row(0, row), *vs = there.row(1, row);
    for (int col = 0; col < there.cols(); col += kEvery) {
      const float u = us[col], v = vs[col];
      if (u * u + v * v < least * least) continue;
      const auto x = static_cast<float>(col), y = static_cast<float>(row);
      if (comes_home(x, y, u, v, back)) land(x + share * u, y + share * v, u, v, landed_), any = true;
    }
  }
  cells_.copy_from(landed_);
  if (!any) return;
  for (int row = 0; row < cells_.rows(); ++row)
    for (int col = 0; col < cells_.cols(); ++col)
      if (landed_.at(0, row, col) == kNowhere) fill_from_neighbours(landed_, row, col, cells_);
}

}  // namespace hdrcam
