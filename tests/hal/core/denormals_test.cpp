// A number below the smallest normal float costs a hundred times a normal one; the threads that fit do
// without.
#include <array>
#include <atomic>
#include <thread>

#include "hal/core/cpu.h"
#include "hal/core/worker_pool.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

// Whether this thread computes with denormals: on the way in (a denormal operand) or out (a denormal result).
bool keeps_denormals() {
  volatile float denormal = 1e-40f, small = 1e-30f, factor = 1e-10f, large = 1e30f;
  const float read = denormal * large, made = small * factor;
  return read != 0 || made != 0;
}

}  // namespace

TEST_CASE("a thread that flushes denormals neither reads nor makes them, and no other thread is changed") {
#if defined(__x86_64__) || defined(__aarch64__)
  bool before = false, after = true;
  std::thread([&] {
    before = keeps_denormals();
    flush_denormals();
    after = keeps_denormals();
  }).join();
  CHECK(before);
  CHECK_FALSE(after);
  CHECK(keeps_denormals());
#endif
}

TEST_CASE("the threads of a pool flush denormals") {
#if defined(__x86_64__) || defined(__aarch64__)
  WorkerPool pool(3);
  const std::thread::id caller = std::this_thread::get_id();
  std::array<bool, 3> kept{};
  std::array<std::thread::id, 3> by{};
  std::atomic<int> inside{0};
  // each piece waits for the others, so that three threads share them
  pool.for_each(3, [&](int i) {
    const auto at = static_cast<std::size_t>(i);
    ++inside;
    while (inside < 3) std::this_thread::yield();
    kept[at] = keeps_denormals();
    by[at] = std::this_thread::get_id();
  });
  for (std::size_t i = 0; i < 3; ++i) CHECK(kept[i] == (by[i] == caller));
#endif
}
