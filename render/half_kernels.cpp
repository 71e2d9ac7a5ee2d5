// Compiled once per instruction set into namespace HDRCAM_TARGET (see hdrcam_kernels() in CMakeLists.txt).
#include "render/half_kernels.h"

namespace hdrcam::HDRCAM_TARGET {
namespace {

constexpr int kMantissa = 23, kHalfMantissa = 10, kLost = kMantissa - kHalfMantissa;  // bits
constexpr std::uint32_t kInfinite = 0x7f800000, kLargest = 0x477fe000;                // 65504
constexpr std::uint32_t kLeastNormal = 0x38800000;                                    // 2^-14
constexpr std::uint32_t kBiases = 127 - 15;
// Added to a number below 2^-14 it leaves the half float in the lowest bits, rounded by the addition itself.
constexpr float kAligned = 0.5f;
constexpr std::uint32_t kAlignedBits = 0x3f000000;

std::uint32_t bits_of(float v) {
  std::uint32_t bits;
  __builtin_memcpy(&bits, &v, sizeof bits);
  return bits;
}

bool to_half(const float* values, std::size_t n, std::uint16_t* bits) {
  std::uint32_t worst = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint32_t all = bits_of(values[i]), magnitude = all & 0x7fffffff;
    worst = magnitude > worst ? magnitude : worst;
    const std::uint32_t m = magnitude < kLargest ? magnitude : kLargest;
    const std::uint32_t odd = m >> kLost & 1;
    const std::uint32_t normal = (m - (kBiases << kMantissa) + ((1U << (kLost - 1)) - 1) + odd) >> kLost;
    float small;
    __builtin_memcpy(&small, &m, sizeof small);
    const std::uint32_t denormal = bits_of(small + kAligned) - kAlignedBits;
    bits[i] = static_cast<std::uint16_t>((m < kLeastNormal ? denormal : normal) | (all >> 16 & 0x8000));
  }
  return worst < kInfinite;
}

}  // namespace

extern const HalfKernels kHalfKernels;
const HalfKernels kHalfKernels = {to_half};

}  // namespace hdrcam::HDRCAM_TARGET
