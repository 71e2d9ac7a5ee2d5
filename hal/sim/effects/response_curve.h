// The response curve of a camera that delivers pictures, not light: relative exposure 0..1 to relative code
// 0..1, one curve per channel. Gamma: x^(1/2.2). Film: (1 + a) x^p / (x^p + a), with a shoulder and a toe; p
// differs slightly per channel, as in measured curves. Immutable, reentrant.
#pragma once

#include <array>
#include <vector>

namespace hdrcam {

enum class CurveShape { Gamma, Film };

class ResponseCurve {
 public:
  explicit ResponseCurve(CurveShape shape);

  // channel 0..2; x is clipped to 0..1. From a table, exact to 1e-4.
  float value(int channel, float x) const;
  // The formula itself.
  static double exact(CurveShape shape, int channel, double x);

 private:
  static constexpr int kSegments = 4096;  // uniform in sqrt(x): dense where the curves are steep
  std::array<std::vector<float>, 3> tables_;
};

}  // namespace hdrcam
