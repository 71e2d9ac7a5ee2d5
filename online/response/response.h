// The camera response: code <-> relative sensor exposure, one curve per channel, monotone, x(255) = 1. Stored
// as the inverse x(z) on the 256 codes (which the state needs, exact in the dark) with a forward table g(x)
// on sqrt(x). The fit's differentiable, leaky curve is scene/hash_grid/fit/learned_response.h. Value type,
// reentrant.
#pragma once

#include <array>
#include <vector>

namespace hdrcam {

class Response {
 public:
  static constexpr int kCodes = 256;
  using Curve = std::array<float, kCodes>;

  // inverse: [rgb][code] relative exposure. It is made monotone, not below 0, and scaled to x(255) = 1; code
  // 0 means "below x(1)", never 0. uncertainty: [rgb][code] one sigma of ln x; none where the curve is known.
  explicit Response(const std::array<Curve, 3>& inverse, const std::array<Curve, 3>& uncertainty = {});
  // Of the curves that another one has, unchanged.
  static Response of_curves(const std::array<Curve, 3>& inverse, const std::array<Curve, 3>& uncertainty);
  static Response linear();
  static Response gamma(float exponent);  // x = (z / 255) ^ exponent

  // code 0..255 (fractions allowed) -> relative exposure 0..1
  float exposure_of(int channel, float code) const;
  // dx/dz at a code: the exposure of one code step
  float slope(int channel, float code) const;
  // one sigma of ln x at a code
  float uncertainty(int channel, float code) const;
  // relative exposure -> code 0..255, clipped
  float code_of(int channel, float x) const;

  const Curve& inverse(int channel) const { return inverse_[static_cast<std::size_t>(channel)]; }
  const Curve& uncertainty(int channel) const { return uncertainty_[static_cast<std::size_t>(channel)]; }

 private:
  static constexpr int kForward = 2048;  // segments of the forward table, uniform in sqrt(x)
  void build_slope();
  void build_forward();

  std::array<Curve, 3> inverse_{};
  std::array<Curve, 3> slope_{}, uncertainty_{};
  std::array<std::vector<float>, 3> forward_;
};

// One sigma of ln x, rms over codes 12..245 and channels.
double uncertainty_of(const Response& response);

}  // namespace hdrcam
