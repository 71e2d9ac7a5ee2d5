// The camera response inside the fit: relative exposure x = E/E_ref * L -> value 0..1, one curve per channel,
// piecewise linear on 256 points, monotone by construction (softplus increments), g(0) = 0 and g(1) = 1. The
// points are uniform in sqrt(x): with uniform x the first segment of a gamma-like curve would cover its
// twenty darkest codes. Outside [0, 1] it leaks (paper, appendix "Tone-mapping"): a x below, 1 + a - a /
// sqrt(x) above, a = 0.01. Scalar type T as in ../field/hash_grid.h. Reading is reentrant.
#pragma once

#include <array>
#include <cmath>

#include "online/response/response.h"

namespace hdrcam {

template <class T>
class LearnedResponse {
 public:
  static constexpr int kPoints = 256, kSegments = kPoints - 1;
  static constexpr T kLeak = T(0.01);
  using Gradient = std::array<std::array<T, kPoints>, 3>;  // with respect to the points' values

  // A value with its derivative by ln x, and the segment it lies on (-1: in a leak).
  struct Value {
    T value, d_log;
    int segment;
    T fraction;
  };

  explicit LearnedResponse(const Response& response) { start_from(response); }

  void start_from(const Response& response);

  Value evaluate(int channel, T x) const {
    if (x >= 1) return {1 + kLeak - kLeak / std::sqrt(x), T(0.5) * kLeak / std::sqrt(x), -1, 0};
    if (!(x > 0)) return {kLeak * x, kLeak * x, -1, 0};  // NaN stays NaN
    const T at = std::sqrt(x) * T(kSegments);
    const int segment = std::min(static_cast<int>(at), kSegments - 1);
    const T fraction = at - T(segment);
    const auto& points = point_[index(channel)];
    const T low = points[index(segment)], step = points[index(segment + 1)] - low;
    return {low + fraction * step, T(0.5) * step * at, segment, fraction};
  }
  // Adds the share of one evaluation, d_value = d loss / d value, to a gradient.
  static void accumulate(int channel, const Value& at, T d_value, Gradient& gradient) {
    if (at.segment < 0) return;
    gradient[index(channel)][index(at.segment)] += d_value * (1 - at.fraction);
    gradient[index(channel)][index(at.segment + 1)] += d_value * at.fraction;
  }

  // d increment [3][kSegments] from d point: point_j = sum_{i<j} softplus(increment_i) / sum_i
  // softplus(increment_i)
  void backward(const Gradient& d_point, std::array<std::array<T, kSegments>, 3>& d_increment) const {
    for (std::size_t c = 0; c < 3; ++c) {
      T total = 0, mean = 0, suffix = 0;
      for (T v : increment_[c]) total += softplus(v);
      for (std::size_t j = 0; j < kPoints; ++j) mean += d_point[c][j] * point_[c][j];
      for (std::size_t i = kSegments; i-- > 0;) {
        suffix += d_point[c][i + 1];
        d_increment[c][i] = (suffix - mean) / total / (1 + std::exp(-increment_[c][i]));
      }
    }
  }

  std::array<std::array<T, kSegments>, 3>& increments() { return increment_; }
  T point(int channel, int j) const { return point_[index(channel)][index(j)]; }

  // Values from increments; call after changing increments().
  void rebuild() {
    for (std::size_t c = 0; c < 3; ++c) {
      T sum = 0;
      point_[c][0] = 0;
      for (std::size_t j = 0; j < kSegments; ++j) point_[c][j + 1] = sum += softplus(increment_[c][j]);
      for (T& value : point_[c]) value /= sum;
    }
  }

 private:
  static constexpr std::size_t index(int i) { return static_cast<std::size_t>(i); }
  static T softplus(T v) { return v > 20 ? v : std::log1p(std::exp(v)); }
  static T inverse_softplus(T v) { return v > 20 ? v : std::log(std::expm1(std::max(v, T(1e-5)))); }

  std::array<std::array<T, kSegments>, 3> increment_{};
  std::array<std::array<T, kPoints>, 3> point_{};
};

// Samples the inverse of the given curve: at x, the fractional code whose exposure is x.
template <class T>
void LearnedResponse<T>::start_from(const Response& response) {
  for (int c = 0; c < 3; ++c) {
    const Response::Curve& exposure = response.inverse(c);
    std::array<T, kPoints> value{};
    int code = 0;
    for (int j = 1; j < kPoints; ++j) {
      const T x = T(j) / T(kSegments) * T(j) / T(kSegments);
      while (code + 1 < Response::kCodes && T(exposure[index(code + 1)]) <= x) ++code;
      const T low = code > 0 ? T(exposure[index(code)]) : T(0);  // code 0 stands for what is darker, too
      const int next = std::min(code + 1, Response::kCodes - 1);
      const T high = T(exposure[index(next)]);
      const T part = high > low ? std::min((x - low) / (high - low), T(1)) : T(0);
      value[index(j)] = (T(code) + part * T(next - code)) / T(Response::kCodes - 1);
    }
    for (int j = 0; j < kSegments; ++j)
      increment_[index(c)][index(j)] =
          inverse_softplus((value[index(j + 1)] - value[index(j)]) * T(kSegments));
  }
  rebuild();
}

}  // namespace hdrcam
