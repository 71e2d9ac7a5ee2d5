// Time that passes only while a thread waits for it: ten thousand frames take as long as computing them, and
// every run has the same instants. Thread-safe.
#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>

#include "hal/clock.h"

namespace hdrcam {

class VirtualClock : public Clock {
 public:
  explicit VirtualClock(Instant start = Instant::from_seconds(1)) : now_(start.since_boot.count()) {}

  Instant now() override { return {Duration(now_.load())}; }
  // Jumps to `when`; an instant in the past does not wait.
  void sleep_until(Instant when) override {
    Duration::rep now = now_.load();
    while (now < when.since_boot.count() && !now_.compare_exchange_weak(now, when.since_boot.count())) {
    }
  }
  // All clocks agree, except that the real-time clock starts in 2000.
  Instant instant_of(ClockDomain domain, Duration timestamp) override {
    return {domain == ClockDomain::Realtime ? timestamp - kRealtimeStart : timestamp};
  }
  std::chrono::system_clock::time_point wall_time() override {
    return std::chrono::system_clock::time_point(
        std::chrono::duration_cast<std::chrono::system_clock::duration>(kRealtimeStart + now().since_boot));
  }

  static constexpr Duration kRealtimeStart = std::chrono::seconds(946'684'800);

 private:
  std::atomic<Duration::rep> now_;
};

// The time of a simulation: this machine's, or a virtual one. Thread-safe.
class SimTime {
 public:
  SimTime() : clock_(posix_clock()), jumps_(false) {}
  explicit SimTime(VirtualClock& clock) : clock_(clock), jumps_(true) {}

  Instant now() const { return clock_.now(); }
  void sleep_until(Instant when) const { clock_.sleep_until(when); }
  // Returns at `when`, or earlier when `wake` is notified. Virtual time jumps to `when` at once.
  void wait(std::unique_lock<std::mutex>& lock, std::condition_variable& wake, Instant when) const {
    if (jumps_)
      clock_.sleep_until(when);
    else if (const Duration left = when - clock_.now(); left > Duration::zero())
      wake.wait_for(lock, left);
  }

 private:
  Clock& clock_;
  bool jumps_;
};

}  // namespace hdrcam
