// The kernel of this processor against the library's conversion of one number.
#include "render/half_kernels.h"

#include <Imath/half.h>

#include <cmath>
#include <limits>
#include <vector>

#include <catch2/catch.hpp>

namespace hdrcam {
namespace {

std::uint16_t rounded(float value) {
  std::uint16_t bits = 0;
  CHECK(half_kernels().to_half(&value, 1, &bits));
  return bits;
}

TEST_CASE(
    "every half float, and what lies between two of them, becomes the half float that it becomes one by "
    "one") {
  std::vector<float> values;
  for (std::uint32_t bits = 0; bits <= 0x7bff; ++bits) {
    Imath::half lower, upper;
    lower.setBits(static_cast<std::uint16_t>(bits)), upper.setBits(static_cast<std::uint16_t>(bits + 1));
    const float a = lower, b = bits < 0x7bff ? float(upper) : 65520.f, middle = 0.5f * (a + b);
    for (const float v :
         {a, std::nextafter(a, b), std::nextafter(middle, a), middle, std::nextafter(middle, b)})
      if (v <= 65504) values.push_back(v), values.push_back(-v);
  }
  for (const float v : {1e-45f, 1e-30f, 5.9e-8f, 2.98e-8f}) values.push_back(v), values.push_back(-v);
  std::vector<std::uint16_t> bits(values.size());
  REQUIRE(half_kernels().to_half(values.data(), values.size(), bits.data()));
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < values.size(); ++i) wrong += bits[i] != Imath::half(values[i]).bits();
  CHECK(wrong == 0);
}

TEST_CASE("light beyond the largest half float is that one, and what is no light is told") {
  CHECK(rounded(65504) == 0x7bff);
  CHECK(rounded(65519.9f) == 0x7bff);
  CHECK(rounded(1e30f) == 0x7bff);
  CHECK(rounded(-1e30f) == 0xfbff);
  std::uint16_t bits[17];
  for (const float bad : {std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(),
                          std::numeric_limits<float>::quiet_NaN(), -std::numeric_limits<float>::quiet_NaN()})
    for (std::size_t at = 0; at < 17; ++at) {
      float values[17] = {};
      values[at] = bad;
      CHECK_FALSE(half_kernels().to_half(values, 17, bits));
    }
  CHECK(half_kernels().to_half(nullptr, 0, nullptr));
}

}  // namespace
}  // namespace hdrcam
