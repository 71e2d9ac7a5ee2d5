#include "hal/core/worker_pool.h"

#include <chrono>
#include <string>

#include "hal/core/check.h"
#include "hal/core/cpu.h"
#include "hal/core/thread_name.h"

namespace hdrcam {
namespace {

void rest_a_moment() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  __asm__ volatile("yield");
#endif
}

// Whether it comes true within about the time that it takes to put a thread to sleep and to wake it again.
// The loops of a frame follow each other within microseconds.
template <class Condition>
bool comes_soon(Condition&& condition) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::microseconds kSoon{50};
  constexpr int kLooks = 16;  // from one look at the clock to the next
  const auto end = Clock::now() + kSoon;
  do
    for (int i = 0; i < kLooks; ++i, rest_a_moment())
      if (condition()) return true;
  while (Clock::now() < end);
  return false;
}

}  // namespace

WorkerPool::WorkerPool(int threads, ThreadPriority priority) {
  CHECK_GT(threads, 0);
  for (int i = 1; i < threads; ++i)
    threads_.emplace_back([this, priority, i] {
      name_this_thread("worker " + std::to_string(i));
      set_priority_of_this_thread(priority);
      serve();
    });
}

WorkerPool::~WorkerPool() {
  {
    std::lock_guard lock(mutex_);
    stop_ = true;
    std::atomic_ref(generation_).fetch_add(2, std::memory_order_release);
  }
  wake_.notify_all();
  for (auto& thread : threads_) thread.join();
}

void WorkerPool::run(int count, Call call, void* context) {
  if (threads_.empty() || count <= 1 || running_) {
    for (int i = 0; i < count; ++i) call(context, i);
    return;
  }
  {
    std::lock_guard lock(mutex_);
    call_ = call, context_ = context, count_ = count;
    next_.store(0, std::memory_order_relaxed);
    running_ = true;
    std::atomic_ref(generation_).fetch_add(1, std::memory_order_release);  // odd: open
  }
  wake_.notify_all();
  work();
  {
    // nothing is left to be taken: who has not begun by now need not be waited for
    std::lock_guard lock(mutex_);
    std::atomic_ref(generation_).fetch_add(1, std::memory_order_release);
  }
  const auto done = [this] { return std::atomic_ref(busy_).load(std::memory_order_acquire) == 0; };
  if (!comes_soon(done)) {
    std::unique_lock lock(mutex_);
    done_.wait(lock, done);
  }
  running_ = false;
}

void WorkerPool::work() {
  for (int i; (i = next_.fetch_add(1, std::memory_order_relaxed)) < count_;) call_(context_, i);
}

// A thread takes part in each loop that it finds open, until the pool ends.
void WorkerPool::serve() {
  flush_denormals();
  unsigned seen = 0;
  const auto changed = [&] { return std::atomic_ref(generation_).load(std::memory_order_acquire) != seen; };
  for (;;) {
    const bool soon = comes_soon(changed);
    {
      std::unique_lock lock(mutex_);
      if (!soon) wake_.wait(lock, changed);
      seen = generation_;
      if (stop_) return;
      if (seen % 2 == 0) continue;  // it is over already
      std::atomic_ref(busy_).fetch_add(1, std::memory_order_relaxed);
    }
    work();
    std::lock_guard lock(mutex_);
    if (std::atomic_ref(busy_).fetch_sub(1, std::memory_order_release) == 1) done_.notify_one();
  }
}

}  // namespace hdrcam
