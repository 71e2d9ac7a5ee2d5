#include "online/response/response.h"

#include <algorithm>
#include <cmath>

namespace hdrcam {
namespace {

constexpr std::size_t kFirst = 12, kLast = 245;  // codes that are judged
constexpr double kCompared = kLast - kFirst + 1;
constexpr float kMinStep = 2e-6f;  // of x from one code to the next: strictly monotone

}  // namespace

Response::Response(const std::array<Curve, 3>& inverse, const std::array<Curve, 3>& uncertainty)
    : inverse_(inverse), uncertainty_(uncertainty) {
  for (auto& x : inverse_) {
    x[0] = std::max({x[0], 0.4f * x[1], 0.f});
    for (std::size_t z = 1; z < kCodes; ++z) x[z] = std::max(x[z], x[z - 1] + kMinStep);
    const float scale = 1 / x[kCodes - 1];
    for (float& value : x) value *= scale;
  }
  build_slope();
  build_forward();
}

Response Response::of_curves(const std::array<Curve, 3>& inverse, const std::array<Curve, 3>& uncertainty) {
  Response response(inverse, uncertainty);
  response.inverse_ = inverse;  // the least steps of a scaled one may be smaller than those of a new one
  response.build_slope();
  response.build_forward();
  return response;
}

void Response::build_slope() {
  for (std::size_t c = 0; c < 3; ++c) {
    const auto& x = inverse_[c];
    for (int z = 0; z < kCodes; ++z) {
      const int lo = std::max(0, z - 1), hi = std::min(kCodes - 1, z + 1);
      slope_[c][static_cast<std::size_t>(z)] =
          (x[static_cast<std::size_t>(hi)] - x[static_cast<std::size_t>(lo)]) / static_cast<float>(hi - lo);
    }
  }
}

void Response::build_forward() {
  for (std::size_t c = 0; c < 3; ++c) {
    const auto& x = inverse_[c];
    auto& table = forward_[c];
    table.resize(kForward + 2);
    std::size_t z = 0;
    for (int i = 0; i <= kForward; ++i) {
      const float root = static_cast<float>(i) / kForward;
      const float value = root * root;
      while (z < kCodes - 2 && x[z + 1] <= value) ++z;
      const float code = static_cast<float>(z) + (value - x[z]) / (x[z + 1] - x[z]);
      table[static_cast<std::size_t>(i)] = std::clamp(code, 0.f, 255.f);
    }
    table[kForward + 1] = table[kForward];
  }
}

Response Response::linear() { return gamma(1); }

Response Response::gamma(float exponent) {
  std::array<Curve, 3> inverse;
  for (auto& curve : inverse)
    for (std::size_t z = 0; z < kCodes; ++z)
      curve[z] = std::max(1e-5f, std::pow(static_cast<float>(z) / 255, exponent));
  return Response(inverse);
}

float Response::exposure_of(int channel, float code) const {
  const auto& x = inverse(channel);
  code = std::clamp(code, 0.f, 255.f);
  const auto z = static_cast<std::size_t>(std::min(254, static_cast<int>(code)));
  return x[z] + (x[z + 1] - x[z]) * (code - static_cast<float>(z));
}

float Response::uncertainty(int channel, float code) const {
  const auto z = static_cast<std::size_t>(std::clamp(code + 0.5f, 0.f, 255.f));
  return uncertainty_[static_cast<std::size_t>(channel)][z];
}

float Response::slope(int channel, float code) const {
  const int z = static_cast<int>(std::clamp(code + 0.5f, 0.f, 255.f));
  return slope_[static_cast<std::size_t>(channel)][static_cast<std::size_t>(z)];
}

float Response::code_of(int channel, float x) const {
  const float position = std::sqrt(std::clamp(x, 0.f, 1.f)) * kForward;
  const auto i = static_cast<std::size_t>(position);
  const auto& table = forward_[static_cast<std::size_t>(channel)];
  return table[i] + (table[i + 1] - table[i]) * (position - static_cast<float>(i));
}

double uncertainty_of(const Response& response) {
  double sum = 0;
  for (int c = 0; c < 3; ++c)
    for (std::size_t z = kFirst; z <= kLast; ++z) {
      const double sigma = response.uncertainty(c, static_cast<float>(z));
      sum += sigma * sigma;
    }
  return std::sqrt(sum / (3 * kCompared));
}

}  // namespace hdrcam
