// Hot pixels: a few pixels of the sensor leak charge, each at its own rate, so that they grow with the
// exposure. Their positions belong to the sensor, not to the frame. Immutable, reentrant.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace hdrcam {

struct HotPixelSettings {
  double share = 2e-4;               // of all samples
  float mean_rate_e_per_s = 60'000;  // exponentially distributed
};

class HotPixels {
 public:
  HotPixels(HotPixelSettings settings, std::uint64_t seed, int channels, int rows, int cols);

  struct Leak {
    int x;
    float rate_e_per_s;
  };
  std::span<const Leak> in_row(int channel, int y) const;
  void add(int channel, int y, float exposure_s, std::span<float> electrons) const {
    for (const Leak& leak : in_row(channel, y))
      electrons[static_cast<std::size_t>(leak.x)] += leak.rate_e_per_s * exposure_s;
  }

 private:
  int rows_;
  std::vector<Leak> leaks_;         // by channel, row, column
  std::vector<std::size_t> first_;  // of each channel's row, and the end
};

}  // namespace hdrcam
