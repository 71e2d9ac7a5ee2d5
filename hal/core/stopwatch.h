// Elapsed time for statistics, on the steady clock. Value type.
#pragma once

#include <chrono>

namespace hdrcam {

class Stopwatch {
 public:
  // milliseconds since construction or the last lap
  double lap_ms() {
    const auto now = std::chrono::steady_clock::now();
    const std::chrono::duration<double, std::milli> spent = now - start_;
    start_ = now;
    return spent.count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace hdrcam
