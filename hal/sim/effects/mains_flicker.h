// Mains flicker: lamps flicker at twice the mains frequency f, 1 + m cos(4 pi f t). An exposure of length e
// around t collects the mean, 1 + m sinc(2 f e) cos(4 pi f t); the flicker vanishes when e is a multiple of 1
// / (2 f). Value type, reentrant.
#pragma once

#include <cmath>
#include <numbers>

namespace hdrcam {

struct MainsFlickerSettings {
  double mains_hz = 50;
  double modulation = 0.3;  // 0..1: incandescent .1, fluorescent .3, bad LED 1
};

class MainsFlicker {
 public:
  explicit MainsFlicker(MainsFlickerSettings settings) : settings_(settings) {}

  // Mean brightness over [begin_s, begin_s + exposure_s], 1 on average.
  float factor(double begin_s, double exposure_s) const {
    // Of the light's own period.
    const double half_angle = 2 * std::numbers::pi * settings_.mains_hz * exposure_s;
    const double sinc = half_angle == 0 ? 1 : std::sin(half_angle) / half_angle;
    const double middle_s = begin_s + exposure_s / 2;
    return static_cast<float>(1 + settings_.modulation * sinc *
                                      std::cos(4 * std::numbers::pi * settings_.mains_hz * middle_s));
  }

 private:
  MainsFlickerSettings settings_;
};

}  // namespace hdrcam
