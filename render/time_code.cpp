#include "render/time_code.h"

#include <algorithm>
#include <cmath>

#include "hal/core/check.h"

namespace hdrcam {

TimeCode time_code(Duration since_start, double framerate_hz) {
  HDRCAM_CHECK(since_start.count() >= 0);
  HDRCAM_CHECK_GT(framerate_hz, 0.0);
  constexpr int kFrames = 30;  // the largest count; faster cameras count pairs, triples.. of frames (ST 12-1)
  // An interval of 33,333 us, or of whole nanoseconds, is 30 Hz and a little more.
  constexpr double kNearly = 0.99;
  const double counts_per_s = framerate_hz / std::ceil(kNearly * framerate_hz / kFrames);
  // Times tremble, and those of Matroska are whole milliseconds: frame n at about n / 30 s is frame n.
  const Duration time = since_start + from_seconds(0.5 / std::max<double>(framerate_hz, kFrames));
  const auto second = time.count() / 1'000'000'000;
  const double fraction = static_cast<double>(time.count() % 1'000'000'000) * 1e-9;
  const int frame = std::min(static_cast<int>(fraction * counts_per_s), kFrames - 1);
  return {static_cast<int>(second / 3600 % 24), static_cast<int>(second / 60 % 60),
          static_cast<int>(second % 60), frame};
}

}  // namespace hdrcam
