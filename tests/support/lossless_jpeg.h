// A mosaic as lossless JPEG (ISO/IEC 10918-1, annex H), as DNG and other raw stills have it: one component of
// 12 bits, predicted from its left neighbour.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

namespace hdrcam::test {

// From the highest bit on; a byte of 0xff is followed by 0.
class JpegBits {
 public:
  explicit JpegBits(std::vector<std::uint8_t>& bytes) : bytes_(bytes) {}
  void put(std::uint32_t value, int bits) {
    while (bits-- > 0) {
      waiting_ = waiting_ << 1 | (value >> bits & 1);
      if (++count_ < 8) continue;
      bytes_.push_back(static_cast<std::uint8_t>(waiting_));
      if (waiting_ == 0xff) bytes_.push_back(0);
      waiting_ = 0, count_ = 0;
    }
  }
  void fill_byte() {
    while (count_ > 0) put(1, 1);
  }

 private:
  std::vector<std::uint8_t>& bytes_;
  std::uint32_t waiting_ = 0;
  int count_ = 0;
};

// codes: [rows, cols], below 4096.
inline std::vector<std::uint8_t> lossless_jpeg(const std::vector<std::uint16_t>& codes, int rows, int cols) {
  constexpr std::uint8_t kBits = 12;
  const auto high = [](int value) { return static_cast<std::uint8_t>(value >> 8); };
  const auto low = [](int value) { return static_cast<std::uint8_t>(value & 0xff); };
  std::vector<std::uint8_t> bytes{0xff,      0xd8,       0xff,      0xc3, 0, 11,   kBits, high(rows),
                                  low(rows), high(cols), low(cols), 1,    0, 0x11, 0};
  constexpr int kCategories = 13, kCodeBits = 4;  // codes of one length for the sizes of differences, 0 to 12
  for (const int byte : {0xff, 0xc4, 0, 19 + kCategories, 0})
    bytes.push_back(static_cast<std::uint8_t>(byte));
  for (int bits = 1; bits <= 16; ++bits)
    bytes.push_back(static_cast<std::uint8_t>(bits == kCodeBits ? kCategories : 0));
  for (int size = 0; size < kCategories; ++size) bytes.push_back(static_cast<std::uint8_t>(size));
  for (const int byte : {0xff, 0xda, 0, 8, 1, 0, 0, 1, 0, 0})
    bytes.push_back(static_cast<std::uint8_t>(byte));
  JpegBits scan(bytes);
  const auto at = [&](int y, int x) {
    return static_cast<int>(
        codes[static_cast<std::size_t>(y) * static_cast<std::size_t>(cols) + static_cast<std::size_t>(x)]);
  };
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < cols; ++x) {
      const int predicted = x > 0 ? at(y, x - 1) : y > 0 ? at(y - 1, 0) : 1 << (kBits - 1);
      const int difference = at(y, x) - predicted;
      const auto size = static_cast<int>(std::bit_width(static_cast<unsigned>(std::abs(difference))));
      scan.put(static_cast<std::uint32_t>(size), kCodeBits);
      scan.put(static_cast<std::uint32_t>(difference >= 0 ? difference : difference + (1 << size) - 1), size);
    }
  scan.fill_byte();
  bytes.push_back(0xff), bytes.push_back(0xd9);
  return bytes;
}

}  // namespace hdrcam::test
