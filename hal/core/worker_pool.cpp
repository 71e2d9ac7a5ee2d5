#include "hal/core/worker_pool.h"

#include <string>

#include "hal/core/check.h"
#include "hal/core/cpu.h"
#include "hal/core/thread_name.h"

namespace hdrcam {

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
    busy_ = static_cast<int>(threads_.size());
    running_ = true;
    ++generation_;
  }
  wake_.notify_all();
  work();
  std::unique_lock lock(mutex_);
  done_.wait(lock, [this] { return busy_ == 0; });
  running_ = false;
}

void WorkerPool::work() {
  for (int i; (i = next_.fetch_add(1, std::memory_order_relaxed)) < count_;) call_(context_, i);
}

void WorkerPool::serve() {
  flush_denormals();
  unsigned seen = 0;
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [&] { return stop_ || generation_ != seen; });
      if (stop_) return;
      seen = generation_;
    }
    work();
    {
      std::lock_guard lock(mutex_);
      if (--busy_ == 0) done_.notify_one();
    }
  }
}

}  // namespace hdrcam
