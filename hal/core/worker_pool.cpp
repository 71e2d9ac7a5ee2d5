#include "hal/core/worker_pool.h"

#include <chrono>
#include <string>
#include <system_error>
#include <utility>

#include "hal/core/check.h"
#include "hal/core/cpu.h"
#include "hal/core/thread_name.h"
#include "hal/core/thrown_by.h"

namespace hdrcam {
namespace {

void cpu_relax() {
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
    for (int i = 0; i < kLooks; ++i, cpu_relax())
      if (condition()) return true;
  while (Clock::now() < end);
  return false;
}

}  // namespace

WorkerPool::WorkerPool(int threads, ThreadPriority priority) : parts_(static_cast<std::size_t>(threads)) {
  HDRCAM_CHECK_GT(threads, 0);
  try {
    for (int i = 1; i < threads; ++i)
      threads_.emplace_back([this, priority, i] {
        name_this_thread("worker " + std::to_string(i));
        set_priority_of_this_thread(priority);
        serve(static_cast<std::size_t>(i));
      });
  } catch (const std::system_error&) {
    // the parts of those that are missing are done by the others
  }
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
    call_ = call, context_ = context;
    share_out(count);
    running_ = true;
    std::atomic_ref(generation_).fetch_add(1, std::memory_order_release);  // odd: open
  }
  wake_.notify_all();
  std::exception_ptr thrown = thrown_by([this] { work(0); });
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
  if (thrown_ != nullptr) thrown = std::exchange(thrown_, nullptr);
  if (thrown != nullptr) std::rethrow_exception(thrown);
}

void WorkerPool::share_out(int count) {
  const auto all = static_cast<std::uint64_t>(count), parts = static_cast<std::uint64_t>(parts_.size());
  for (std::uint64_t t = 0; t < parts; ++t) {
    const std::uint64_t first = all * t / parts, end = all * (t + 1) / parts;
    parts_[t].left.store(first | end << 32, std::memory_order_relaxed);
  }
}

// A thread takes its own part from the front, then what is left of the others' from behind.
void WorkerPool::work(std::size_t thread) {
  constexpr std::uint64_t kOneBehind = 1ULL << 32;
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    std::atomic<std::uint64_t>& part = parts_[(thread + k) % parts_.size()].left;
    const bool own = k == 0;
    std::uint64_t left = part.load(std::memory_order_relaxed);
    for (;;) {
      const std::uint64_t first = left % kOneBehind, end = left / kOneBehind;
      if (first == end) break;
      const std::uint64_t rest = own ? left + 1 : left - kOneBehind;
      if (!part.compare_exchange_weak(left, rest, std::memory_order_relaxed)) continue;
      call_(context_, static_cast<int>(own ? first : end - 1));
      left = part.load(std::memory_order_relaxed);
    }
  }
}

// A thread takes part in each loop that it finds open, until the pool ends.
void WorkerPool::serve(std::size_t thread) {
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
    std::exception_ptr thrown = thrown_by([&] { work(thread); });
    std::lock_guard lock(mutex_);
    if (thrown != nullptr) thrown_ = std::move(thrown);  // this thread keeps no share of it
    if (std::atomic_ref(busy_).fetch_sub(1, std::memory_order_release) == 1) done_.notify_one();
  }
}

}  // namespace hdrcam
