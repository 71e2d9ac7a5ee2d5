#include "firmware_host/run/backoff.h"

#include <algorithm>
#include <cmath>

namespace hdrcam {
namespace {

constexpr double kFirstWait_s = 4, kMostFirstWait = 10'000;  // the second in frames
constexpr int kLongestWait = 16;                             // in first waits
constexpr double kFasterMachine = 0.85;                      // of the time for the same work

}  // namespace

Backoff::Backoff(Duration frame)
    : first_(
          static_cast<int>(std::lround(std::clamp(kFirstWait_s / to_seconds(frame), 1.0, kMostFirstWait)))),
      next_(first_) {}

void Backoff::begin(double steady_ms) {
  frames_left_ = next_;
  next_ = std::min(2 * next_, kLongestWait * first_);
  steady_ms_ = steady_ms;
}

bool Backoff::pass() {
  if (is_over()) return false;
  --frames_left_;
  return is_over();
}

bool Backoff::is_machine_faster(double steady_ms) const { return steady_ms <= kFasterMachine * steady_ms_; }

void Backoff::reset() {
  frames_left_ = 0;
  shorten_next();
}

}  // namespace hdrcam
