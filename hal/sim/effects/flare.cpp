#include "hal/sim/effects/flare.h"

#include <cmath>

namespace hdrcam {

Flare::Flare(FlareSettings settings, int rows, int cols)
    : strength_(settings.strength),
      radius_(std::max(1, static_cast<int>(std::lround(settings.reach * static_cast<float>(cols) / kCell)))),
      halo_(3, (rows + kCell - 1) / kCell, (cols + kCell - 1) / kCell),
      line_(3, halo_.rows(), halo_.cols()) {}

void Flare::apply(Image<float>& light, WorkerPool& pool) {
  pool.for_each(3, [&](int channel) {
    shrink(light, channel);
    for (int pass = 0; pass < 3; ++pass) box_rows(channel), box_columns(channel);
  });
  pool.for_rows(light.rows(), [&](int y0, int y1) {
    for (int channel = 0; channel < 3; ++channel)
      for (int y = y0; y < y1; ++y) {
        float* row = light.row(channel, y);
        const float cell_y = (static_cast<float>(y) + 0.5f) / kCell - 0.5f;
        for (int x = 0; x < light.cols(); ++x) {
          const float cell_x = (static_cast<float>(x) + 0.5f) / kCell - 0.5f;
          row[x] = (1 - strength_) * row[x] + strength_ * halo_at(channel, cell_y, cell_x);
        }
      }
  });
}

void Flare::shrink(const Image<float>& light, int channel) {
  for (int v = 0; v < halo_.rows(); ++v)
    for (int u = 0; u < halo_.cols(); ++u) {
      const int y1 = std::min(light.rows(), (v + 1) * kCell), x1 = std::min(light.cols(), (u + 1) * kCell);
      float sum = 0;
      for (int y = v * kCell; y < y1; ++y)
        for (int x = u * kCell; x < x1; ++x) sum += light.at(channel, y, x);
      halo_.at(channel, v, u) = sum / static_cast<float>((y1 - v * kCell) * (x1 - u * kCell));
    }
}

void Flare::box_rows(int channel) {
  const int cols = halo_.cols();
  for (int v = 0; v < halo_.rows(); ++v)
    for (int u = 0; u < cols; ++u) {
      float sum = 0;
      for (int k = u - radius_; k <= u + radius_; ++k)
        sum += halo_.at(channel, v, std::clamp(k, 0, cols - 1));
      line_.at(channel, v, u) = sum / static_cast<float>(2 * radius_ + 1);
    }
}

void Flare::box_columns(int channel) {
  const int rows = halo_.rows();
  for (int v = 0; v < rows; ++v)
    for (int u = 0; u < halo_.cols(); ++u) {
      float sum = 0;
      for (int k = v - radius_; k <= v + radius_; ++k)
        sum += line_.at(channel, std::clamp(k, 0, rows - 1), u);
      halo_.at(channel, v, u) = sum / static_cast<float>(2 * radius_ + 1);
    }
}

float Flare::halo_at(int channel, float y, float x) const {
  const float cy = std::clamp(y, 0.f, static_cast<float>(halo_.rows() - 1));
  const float cx = std::clamp(x, 0.f, static_cast<float>(halo_.cols() - 1));
  const int y0 = static_cast<int>(cy), x0 = static_cast<int>(cx);
  const int y1 = std::min(y0 + 1, halo_.rows() - 1), x1 = std::min(x0 + 1, halo_.cols() - 1);
  const float fy = cy - static_cast<float>(y0), fx = cx - static_cast<float>(x0);
  return (halo_.at(channel, y0, x0) * (1 - fx) + halo_.at(channel, y0, x1) * fx) * (1 - fy) +
         (halo_.at(channel, y1, x0) * (1 - fx) + halo_.at(channel, y1, x1) * fx) * fy;
}

}  // namespace hdrcam
