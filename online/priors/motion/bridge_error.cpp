#include "online/priors/motion/bridge_error.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "online/priors/motion/landing.h"

namespace hdrcam {
namespace {

constexpr int kReach = 3;              // cells, both ways
constexpr int kEvery = 4, kFirst = 1;  // rows of a cell that are compared

// What cells count by their distance along an axis: a Gaussian.
std::array<float, kReach + 1> fading() {
  constexpr float kSigma = 1.5f;  // cells
  std::array<float, kReach + 1> weights{};
  for (int d = 0; d <= kReach; ++d)
    weights[static_cast<std::size_t>(d)] = std::exp(-static_cast<float>(d * d) / (2 * kSigma * kSigma));
  return weights;
}

}  // namespace

BridgeError::BridgeError(int rows, int cols)
    : rows_(rows),
      cols_(cols),
      down_(landing_cells(rows)),
      across_(landing_cells(cols)),
      sums_(static_cast<std::size_t>(down_) * static_cast<std::size_t>(across_)),
      off_(2, down_, across_) {}

void BridgeError::compare(const PathAhead& path, const Image<float>& clipped,
                          const Image<float>& clipped_after, const Image<float>& motion, WorkerPool& pool) {
  pool.for_rows(down_, [&](int begin, int end) {
    for (int down = begin; down < end; ++down) {
      CheckedPathCell* cells = &sums_[static_cast<std::size_t>(down) * static_cast<std::size_t>(across_)];
      std::fill_n(cells, across_, CheckedPathCell{});
      const int bottom = std::min((down + 1) * kLandingCell, rows_);
      for (int y = std::min(down * kLandingCell + kFirst, bottom - 1); y < bottom; y += kEvery)
        clipped_motion_kernels().compare({.at = {rows_, cols_, y},
                                          .clipped = clipped.row(0, y),
                                          .clipped_after = clipped_after.plane(0),
                                          .path = path,
                                          .u = motion.row(0, y),
                                          .v = motion.row(1, y),
                                          .cells = cells});
    }
  });
  pool.for_rows(down_, [&](int begin, int end) {
    for (int down = begin; down < end; ++down)
      for (int across = 0; across < across_; ++across) spread_to(down, across);
  });
}

// Sums over the cells around this one that move as it does, in cells.
CheckedPathCell BridgeError::told_around(int down, int across) const {
  constexpr float kAlike2 = 0.8f;  // pixels^2 between two paths: such cells count a quarter
  static const std::array<float, kReach + 1> kFading = fading();
  const CheckedPathCell& here = cell(down, across);
  const float u = here.path_u / here.pixels, v = here.path_v / here.pixels;
  CheckedPathCell sums;
  for (int row = std::max(down - kReach, 0); row <= std::min(down + kReach, down_ - 1); ++row)
    for (int col = std::max(across - kReach, 0); col <= std::min(across + kReach, across_ - 1); ++col) {
      const CheckedPathCell& other = cell(row, col);
      const float du = other.path_u / other.pixels - u, dv = other.path_v / other.pixels - v;
      const float alike = 1 / (1 + (du * du + dv * dv) / kAlike2);
      const float weight = kFading[static_cast<std::size_t>(std::abs(row - down))] *
                           kFading[static_cast<std::size_t>(std::abs(col - across))] * alike * alike /
                           other.pixels;
      sums.told += weight * other.told, sums.off2 += weight * other.off2;
      sums.off_u += weight * other.off_u, sums.off_v += weight * other.off_v;
    }
  return sums;
}

void BridgeError::spread_to(int down, int across) {
  constexpr float kFew = 0.4f;       // cells that show the motion: their word counts half
  constexpr float kDoubt = 10;       // times the variance of what they say, beside its square
  constexpr float kNothing = 1e-6f;  // pixels^2
  const CheckedPathCell sums = told_around(down, across);
  float share = 0;
  if (sums.told > 0) {
    const float mean2 = (sums.off_u * sums.off_u + sums.off_v * sums.off_v) / (sums.told * sums.told);
    const float variance = std::max(sums.off2 / sums.told - mean2, 0.f);
    share = mean2 / (mean2 + kDoubt * variance + kNothing) / (sums.told + kFew);
  }
  off_.at(0, down, across) = share * sums.off_u;
  off_.at(1, down, across) = share * sums.off_v;
}

}  // namespace hdrcam
