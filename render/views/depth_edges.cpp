#include "render/views/depth_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "hal/core/median.h"
#include "render/srgb.h"

namespace hdrcam {
namespace {

constexpr float kReach_px = 24;  // sigma in space where the picture is even
constexpr float kStep = 0.5f;    // of ln luminance: a step as large counts as the whole reach

}  // namespace

void DepthEdges::follow(const Image<float>& radiance, float offset, Image<float>& inverse_depth) {
  constexpr int kRounds = 3;
  take_median(inverse_depth, calm_);
  measure_gaps(radiance, offset);
  for (int round = 0; round < kRounds; ++round) {
    // each round half as far as the one before; their variances add up to that of the reach
    const float sigma = kReach_px * std::sqrt(3.f) * static_cast<float>(1 << (kRounds - round - 1)) /
                        std::sqrt(static_cast<float>((1 << (2 * kRounds)) - 1));
    smooth_rows(sigma, calm_);
    smooth_cols(sigma, calm_);
  }
  inverse_depth.copy_from(calm_);
}

void DepthEdges::take_median(const Image<float>& in, Image<float>& out) {
  constexpr int kRadius = 2;
  const int rows = in.rows(), cols = in.cols();
  out.reshape(1, rows, cols);
  pool_.for_rows(rows, [&](int y0, int y1) {
    std::array<float, (2 * kRadius + 1) * (2 * kRadius + 1)> around{};
    for (int y = y0; y < y1; ++y)
      for (int x = 0; x < cols; ++x) {
        std::size_t n = 0;
        for (int dy = -kRadius; dy <= kRadius; ++dy)
          for (int dx = -kRadius; dx <= kRadius; ++dx)
            around[n++] = in.at(0, std::clamp(y + dy, 0, rows - 1), std::clamp(x + dx, 0, cols - 1));
        out.at(0, y, x) = median(std::span<float>(around));
      }
  });
}

void DepthEdges::measure_gaps(const Image<float>& radiance, float offset) {
  const int rows = radiance.rows(), cols = radiance.cols();
  log_luminance_.reshape(1, rows, cols);
  for (std::size_t i = 0; i < log_luminance_.size(); ++i)
    log_luminance_.samples()[i] = std::log(offset + luminance_at(radiance, i));
  gap_.reshape(2, rows, cols);
  constexpr float kPerStep = kReach_px / kStep;
  pool_.for_rows(rows, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y)
      for (int x = 0; x < cols; ++x) {
        const float here = log_luminance_.at(0, y, x);
        gap_.at(0, y, x) = 1 + kPerStep * std::abs(here - log_luminance_.at(0, y, std::max(x - 1, 0)));
        gap_.at(1, y, x) = 1 + kPerStep * std::abs(here - log_luminance_.at(0, std::max(y - 1, 0), x));
      }
  });
}

void DepthEdges::smooth_rows(float sigma, Image<float>& depth) {
  const float decay = -std::sqrt(2.f) / sigma;  // of ln weight, per pixel of distance
  const int cols = depth.cols();
  pool_.for_rows(depth.rows(), [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      float* row = depth.row(0, y);
      const float* gap = gap_.row(0, y);
      for (int x = 1; x < cols; ++x) row[x] += std::exp(decay * gap[x]) * (row[x - 1] - row[x]);
      for (int x = cols - 2; x >= 0; --x) row[x] += std::exp(decay * gap[x + 1]) * (row[x + 1] - row[x]);
    }
  });
}

void DepthEdges::smooth_cols(float sigma, Image<float>& depth) {
  const float decay = -std::sqrt(2.f) / sigma;
  const int rows = depth.rows();
  pool_.for_rows(depth.cols(), [&](int x0, int x1) {  // bands of columns
    for (int y = 1; y < rows; ++y)
      for (int x = x0; x < x1; ++x)
        depth.at(0, y, x) += std::exp(decay * gap_.at(1, y, x)) * (depth.at(0, y - 1, x) - depth.at(0, y, x));
    for (int y = rows - 2; y >= 0; --y)
      for (int x = x0; x < x1; ++x)
        depth.at(0, y, x) +=
            std::exp(decay * gap_.at(1, y + 1, x)) * (depth.at(0, y + 1, x) - depth.at(0, y, x));
  });
}

}  // namespace hdrcam
