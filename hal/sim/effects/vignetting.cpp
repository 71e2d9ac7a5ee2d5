#include "hal/sim/effects/vignetting.h"

namespace hdrcam {

Vignetting::Vignetting(VignettingSettings settings, const Intrinsics& lens, int rows, int cols)
    : factor_(1, rows, cols) {
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < cols; ++x) {
      const double dx = (x + 0.5 - lens.cx_px) / lens.fx_px, dy = (y + 0.5 - lens.cy_px) / lens.fy_px;
      const double cosine_squared = 1 / (1 + dx * dx + dy * dy);
      factor_.at(0, y, x) = static_cast<float>(std::pow(cosine_squared, 2.0 * settings.strength));
    }
}

void Vignetting::apply_row(Image<float>& light, int y) const {
  const float* factor = factor_.row(0, y);
  for (int c = 0; c < light.channels(); ++c) {
    float* row = light.row(c, y);
    for (int x = 0; x < light.cols(); ++x) row[x] *= factor[x];
  }
}

}  // namespace hdrcam
