#include "hal/sim/effects/response_curve.h"

#include <algorithm>
#include <cmath>

namespace hdrcam {

double ResponseCurve::exact(CurveShape shape, int channel, double x) {
  if (shape == CurveShape::Gamma) return std::pow(x, 1 / 2.2);
  constexpr double kPower[3] = {0.62, 0.60, 0.58}, kShoulder = 0.6;
  const double y = std::pow(x, kPower[channel]);
  return (1 + kShoulder) * y / (y + kShoulder);
}

ResponseCurve::ResponseCurve(CurveShape shape) {
  for (int channel = 0; channel < 3; ++channel) {
    auto& table = tables_[static_cast<std::size_t>(channel)];
    table.resize(kSegments + 1);
    for (int i = 0; i <= kSegments; ++i) {
      const double root = static_cast<double>(i) / kSegments;
      table[static_cast<std::size_t>(i)] = static_cast<float>(exact(shape, channel, root * root));
    }
  }
}

float ResponseCurve::value(int channel, float x) const {
  const auto& table = tables_[static_cast<std::size_t>(channel)];
  const float place = std::sqrt(std::clamp(x, 0.f, 1.f)) * kSegments;
  const int i = std::min(static_cast<int>(place), kSegments - 1);
  const float t = place - static_cast<float>(i);
  const float* node = &table[static_cast<std::size_t>(i)];
  return node[0] + t * (node[1] - node[0]);
}

}  // namespace hdrcam
