// Logarithm and exponential for the kernels that are compiled once per instruction set (*_kernels.cpp): plain
// arithmetic, which the compiler vectorises, where a call of libm would end the vector. Internal linkage, as
// for lanes.h.
#pragma once

namespace hdrcam::HDRCAM_TARGET {
namespace {

// Natural logarithm and exponential of ordinary numbers, to 2 units in the last place (the polynomials of
// Moshier's Cephes).
[[maybe_unused]] inline float log_of(float a) {
  const int bits = __builtin_bit_cast(int, a);
  const int exponent = (bits - 0x3f3504f3) >> 23;
  const float f = __builtin_bit_cast(float, bits - exponent * (1 << 23)) - 1,
              e = static_cast<float>(exponent);
  float p = 7.0376836292e-2f;
  p = p * f - 1.1514610310e-1f, p = p * f + 1.1676998740e-1f, p = p * f - 1.2420140846e-1f;
  p = p * f + 1.4249322787e-1f, p = p * f - 1.6668057665e-1f, p = p * f + 2.0000714765e-1f;
  p = p * f - 2.4999993993e-1f, p = p * f + 3.3333331174e-1f;
  return f + (p * f * f * f - 0.5f * f * f - 2.12194440e-4f * e) + 0.693359375f * e;
}
[[maybe_unused]] inline float exp_of(float x) {
  constexpr float kMost = 87;  // beyond it a float overflows
  x = x > -kMost ? (x < kMost ? x : kMost) : -kMost;
  const int n = static_cast<int>(x * 1.44269504f + (x < 0 ? -0.5f : 0.5f));
  const float r = x - static_cast<float>(n) * 0.693359375f + static_cast<float>(n) * 2.12194440e-4f;
  float p = 1.9875691500e-4f;
  p = p * r + 1.3981999507e-3f, p = p * r + 8.3334519073e-3f, p = p * r + 4.1665795894e-2f;
  p = p * r + 1.6666665459e-1f, p = p * r + 5.0000001201e-1f;
  return (p * r * r + r + 1) * __builtin_bit_cast(float, (n + 127) * (1 << 23));
}

}  // namespace
}  // namespace hdrcam::HDRCAM_TARGET
