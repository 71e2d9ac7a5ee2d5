// Rows of numbers from a seed, for tests that compare a kernel with its plain twin.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

namespace hdrcam::test {

using Row = std::vector<float>;

class Numbers {
 public:
  explicit Numbers(std::uint32_t seed) : engine_(seed) {}

  Row between(float low, float high, int n) {
    Row row(static_cast<std::size_t>(n));
    for (float& v : row) v = std::uniform_real_distribution<float>(low, high)(engine_);
    return row;
  }

 private:
  std::mt19937 engine_;
};

}  // namespace hdrcam::test
