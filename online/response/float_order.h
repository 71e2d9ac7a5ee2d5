// Orders many numbers by their bits, eleven at a time: a picture's worth takes a tenth of the time of
// comparisons, and the first HDR frame waits for it. Reentrant.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

namespace hdrcam {

// Ascending; no NaN. scratch: room that may be reused.
inline void sort_floats(std::vector<float>& values, std::vector<float>& scratch) {
  constexpr int kBits = 11, kPasses = 3;
  constexpr std::uint32_t kDigits = 1u << kBits;
  // bits that are ordered as the numbers are
  const auto key = [](float v) {
    const auto bits = std::bit_cast<std::uint32_t>(v);
    return bits >> 31 ? ~bits : bits | 0x80000000u;
  };
  std::array<std::array<std::uint32_t, kDigits>, kPasses> place{};
  for (const float v : values)
    for (int pass = 0; pass < kPasses; ++pass)
      ++place[static_cast<std::size_t>(pass)][key(v) >> (pass * kBits) & (kDigits - 1)];
  std::array<bool, kPasses> all_alike{};  // as the last digits of 8-bit codes are: nothing to order
  for (std::size_t pass = 0; pass < kPasses; ++pass) {
    std::uint32_t begin = 0;
    for (std::uint32_t& digit : place[pass]) {
      const std::uint32_t count = digit;
      if (count == values.size()) all_alike[pass] = true;
      digit = begin, begin += count;
    }
  }
  scratch.resize(values.size());
  for (int pass = 0; pass < kPasses; ++pass) {
    if (all_alike[static_cast<std::size_t>(pass)]) continue;
    auto& begins = place[static_cast<std::size_t>(pass)];
    for (const float v : values) scratch[begins[key(v) >> (pass * kBits) & (kDigits - 1)]++] = v;
    values.swap(scratch);
  }
}

}  // namespace hdrcam
