// What a frame takes on each rung of the ladder (budget_ladder.h): what it took when the rung was last in
// use, in units of the steady work, which no rung changes. Other work that slows the machine slows both
// alike. A rung that was never in use has no known cost. No allocation after the constructor. Thread-bound.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "firmware_host/run/rung_times.h"

namespace hdrcam {

class RungCosts {
 public:
  explicit RungCosts(std::size_t rungs) : ratios_(rungs) {}

  bool knows(std::size_t rung) const { return ratios_[rung].has_value(); }
  // None where it is not known. steady_ms: of the machine at present.
  std::optional<double> frame_ms(std::size_t rung, double steady_ms) const;
  // The same of a rung cheaper than `present`, whose frames take `now`. One of unknown cost is taken to lie
  // evenly between the present one and the next cheaper one that is known; none where there is none.
  std::optional<double> expected_ms(std::size_t rung, std::size_t present, const FrameTime& now) const;

  void remember(std::size_t rung, double ratio) { ratios_[rung] = ratio; }  // FrameTime::ratio()
  void forget(std::size_t rung) { ratios_[rung].reset(); }

 private:
  std::vector<std::optional<double>> ratios_;
};

}  // namespace hdrcam
