#include "online/priors/motion/far_patches.h"

#include <algorithm>
#include <cmath>

namespace hdrcam {
namespace {

bool agree(const Image<float>& far, int row, int col, int other_row, int other_col) {
  constexpr float kApart = 2;  // pixels: what turns or comes nearer moves a little differently in each patch
  return std::abs(far.at(0, row, col) - far.at(0, other_row, other_col)) <= kApart &&
         std::abs(far.at(1, row, col) - far.at(1, other_row, other_col)) <= kApart;
}

int agreeing_neighbours(const Image<float>& far, int row, int col) {
  int count = -1;  // itself
  for (int y = std::max(row - 1, 0); y <= std::min(row + 1, far.rows() - 1); ++y)
    for (int x = std::max(col - 1, 0); x <= std::min(col + 1, far.cols() - 1); ++x)
      count += agree(far, row, col, y, x) ? 1 : 0;
  return count;
}

}  // namespace

int keep_agreeing(const Image<float>& far, Image<float>& kept) {
  constexpr int kLeast = 3;
  int count = 0;
  kept.reshape_like(far);
  kept.fill(kNowhere);
  for (int row = 0; row < far.rows(); ++row)
    for (int col = 0; col < far.cols(); ++col) {
      if (far.at(0, row, col) == kNowhere || agreeing_neighbours(far, row, col) < kLeast) continue;
      for (int c = 0; c < 2; ++c) kept.at(c, row, col) = far.at(c, row, col);
      ++count;
    }
  return count;
}

void take_far(const Image<float>& far, const PatchSearch& search, Image<float>& others_back) {
  const PatchGrid& grid = search.grid;
  for (int row = 0; row < grid.rows; ++row)
    for (int col = 0; col < grid.cols; ++col) {
      const float u = far.at(0, row, col), v = far.at(1, row, col);
      if (u == kNowhere) continue;
      const int i = row * grid.cols + col;
      search.patches.u[i] = u, search.patches.v[i] = v;
      // the four patches around the place that it leads to, which is in the picture
      const int x = std::min(col * grid.stride, search.from.cols - kPatchSize) + static_cast<int>(u);
      const int y = std::min(row * grid.stride, search.from.rows - kPatchSize) + static_cast<int>(v);
      for (int k = 0; k < 4; ++k) {
        const int back_row = std::min(y / grid.stride + k / 2, grid.rows - 1);
        const int back_col = std::min(x / grid.stride + k % 2, grid.cols - 1);
        others_back.at(0, back_row, back_col) = -u, others_back.at(1, back_row, back_col) = -v;
      }
    }
}

}  // namespace hdrcam
