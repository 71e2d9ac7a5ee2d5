#include "capture/frame_interval.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "hal/core/median.h"

namespace hdrcam {

// One long interval is a lost frame, many are a slow camera.
void FrameInterval::observe(std::uint64_t frames, Duration elapsed) {
  constexpr double kJitter = 0.02;
  intervals_[count_++ % kKept] = elapsed / static_cast<Duration::rep>(frames);
  if (!measured()) return;
  auto sorted = intervals_;
  const Duration middle = median(std::span(sorted).first(std::min<std::size_t>(count_, kKept)));
  const auto agreed = static_cast<double>(agreed_.count());
  const bool keeps = std::abs(static_cast<double>(middle.count()) - agreed) <= kJitter * agreed;
  value_ = keeps ? agreed_ : middle;
}

}  // namespace hdrcam
