// The clocks of this machine. The offset between two clocks is measured by reading them in a sandwich (a, b,
// a) and keeping the narrowest of a few, so that interrupts do not matter. Suspend moves the boot clock
// against the monotonic one and NTP moves the real time, so the offsets are measured again when they are
// older than a second.
#include <time.h>

#include <cerrno>
#include <mutex>

#include "hal/clock.h"

namespace hdrcam {
namespace {

constexpr Duration kOffsetAge = std::chrono::seconds(1);
// The difference between two measurements of one offset.
constexpr Duration kSameOffset = std::chrono::microseconds(20);
constexpr int kSandwiches = 8;

Duration read(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return std::chrono::seconds(now.tv_sec) + std::chrono::nanoseconds(now.tv_nsec);
}

// boot clock - other clock
Duration measure_offset(clockid_t other) {
  Duration narrowest = Duration::max(), offset{};
  for (int i = 0; i < kSandwiches; ++i) {
    const Duration before = read(CLOCK_BOOTTIME);
    const Duration between = read(other);
    const Duration after = read(CLOCK_BOOTTIME);
    if (after - before < narrowest)
      narrowest = after - before, offset = before + (after - before) / 2 - between;
  }
  return offset;
}

// The offset of one clock. A new measurement within the noise of the old one is ignored: the interval
// between two stamps of a steady clock must not jitter because they were converted at different times.
class Offset {
 public:
  explicit Offset(clockid_t other) : other_(other) {}

  Duration value(Duration boot_now) {
    const std::lock_guard lock(mutex_);
    if (boot_now < measured_at_ + kOffsetAge) return offset_;
    const Duration measured = measure_offset(other_);
    if (!measured_ || std::chrono::abs(measured - offset_) > kSameOffset) offset_ = measured;
    measured_ = true, measured_at_ = boot_now;
    return offset_;
  }

 private:
  std::mutex mutex_;
  clockid_t other_;
  Duration offset_{}, measured_at_ = -kOffsetAge;
  bool measured_ = false;
};

class PosixClock : public Clock {
 public:
  Instant now() override { return {read(CLOCK_BOOTTIME)}; }

  void sleep_until(Instant when) override {
    const auto whole = std::chrono::duration_cast<std::chrono::seconds>(when.since_boot);
    timespec until{};
    until.tv_sec = whole.count(), until.tv_nsec = (when.since_boot - whole).count();
    if (when.since_boot <= Duration::zero()) return;
    while (clock_nanosleep(CLOCK_BOOTTIME, TIMER_ABSTIME, &until, nullptr) == EINTR) {
    }
  }

  Instant instant_of(ClockDomain domain, Duration timestamp) override {
    switch (domain) {
      case ClockDomain::Monotonic:
        return {timestamp + monotonic_.value(read(CLOCK_BOOTTIME))};
      case ClockDomain::Realtime:
        return {timestamp + realtime_.value(read(CLOCK_BOOTTIME))};
      case ClockDomain::Boot:
        break;
    }
    return {timestamp};
  }

  std::chrono::system_clock::time_point wall_time() override { return std::chrono::system_clock::now(); }

 private:
  Offset monotonic_{CLOCK_MONOTONIC}, realtime_{CLOCK_REALTIME};
};

}  // namespace

Clock& posix_clock() {
  static PosixClock clock;
  return clock;
}

}  // namespace hdrcam
