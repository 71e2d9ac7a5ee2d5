// A point in time: nanoseconds of the boot clock (CLOCK_BOOTTIME), the one clock of this program. Timestamps
// of other clocks (V4L2 buffers and GPIO edges are monotonic) are converted inside hal/. Value type,
// reentrant.
#pragma once

#include <chrono>
#include <compare>

namespace hdrcam {

using Duration = std::chrono::nanoseconds;

// To the nearest nanosecond.
inline Duration from_seconds(double seconds) {
  return Duration(static_cast<Duration::rep>(seconds * 1e9 + (seconds < 0 ? -0.5 : 0.5)));
}
inline double to_seconds(Duration d) { return static_cast<double>(d.count()) * 1e-9; }

struct Instant {
  Duration since_boot{0};

  static Instant from_seconds(double seconds) { return {hdrcam::from_seconds(seconds)}; }
  double seconds() const { return static_cast<double>(since_boot.count()) * 1e-9; }

  friend bool operator==(const Instant&, const Instant&) = default;
  friend auto operator<=>(const Instant& a, const Instant& b) { return a.since_boot <=> b.since_boot; }
  friend Duration operator-(Instant a, Instant b) { return a.since_boot - b.since_boot; }
  friend Instant operator+(Instant a, Duration d) { return {a.since_boot + d}; }
};

}  // namespace hdrcam
