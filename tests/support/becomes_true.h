// Waits for what another thread or process does, however busy the machine is. Reentrant.
#pragma once

#include <chrono>
#include <thread>

namespace hdrcam::test {

// Whether it does within half a minute. condition: asked again every 2 ms.
template <class Condition>
bool becomes_true(Condition&& condition) {
  constexpr std::chrono::seconds kPatience{30};
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

}  // namespace hdrcam::test
