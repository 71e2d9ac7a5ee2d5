#include "firmware_host/run/rung_costs.h"

namespace hdrcam {

std::optional<double> RungCosts::frame_ms(std::size_t rung, double steady_ms) const {
  if (!ratios_[rung]) return std::nullopt;
  return *ratios_[rung] * steady_ms;
}

std::optional<double> RungCosts::expected_ms(std::size_t rung, std::size_t present,
                                             const FrameTime& now) const {
  std::size_t known = rung;
  while (known < ratios_.size() && !ratios_[known]) ++known;
  if (known == ratios_.size()) return std::nullopt;
  const double way = static_cast<double>(rung - present) / static_cast<double>(known - present);
  const double ratio = now.ratio() + (*ratios_[known] - now.ratio()) * way;
  return ratio * now.steady_ms;
}

}  // namespace hdrcam
