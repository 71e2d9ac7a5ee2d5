#include "hal/sim/effects/hot_pixels.h"

#include <cmath>

#include "hal/sim/counter_random.h"

namespace hdrcam {

HotPixels::HotPixels(HotPixelSettings settings, std::uint64_t seed, int channels, int rows, int cols)
    : rows_(rows) {
  constexpr std::uint64_t kPlaceStream = 0x686f74, kRateStream = 0x6c65616b;
  const CounterRandom place(seed, kPlaceStream), rate(seed, kRateStream);
  std::uint64_t sample = 0;
  const int lines = channels * rows;
  first_.reserve(static_cast<std::size_t>(lines) + 1);
  for (int line = 0; line < lines; ++line) {
    first_.push_back(leaks_.size());
    for (int x = 0; x < cols; ++x, ++sample)
      if (place.uniform(sample) < settings.share)
        leaks_.push_back({x, -settings.mean_rate_e_per_s * std::log(1 - rate.uniform(sample))});
  }
  first_.push_back(leaks_.size());
}

std::span<const HotPixels::Leak> HotPixels::in_row(int channel, int y) const {
  const auto row =
      static_cast<std::size_t>(channel) * static_cast<std::size_t>(rows_) + static_cast<std::size_t>(y);
  return std::span(leaks_).subspan(first_[row], first_[row + 1] - first_[row]);
}

}  // namespace hdrcam
