// A fixed set of threads for data-parallel loops. The work of each index does not depend on the thread that
// takes it, so a result never depends on the number of threads; reductions run over a fixed partition, not
// per thread. Thread-bound: one thread owns the pool and calls for_each; nested calls run in place. Who works
// on a pool works alone, so the pool also lends the pictures that such work needs meanwhile.
#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <type_traits>
#include <vector>

#include "hal/core/scratch_pictures.h"
#include "hal/core/thread_priority.h"

namespace hdrcam {

class WorkerPool {
 public:
  // threads: 1.. ; the calling thread is one of them.
  // priority: of the threads that it starts.
  explicit WorkerPool(int threads, ThreadPriority priority = ThreadPriority::Usual);
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  int threads() const { return static_cast<int>(threads_.size()) + 1; }
  ScratchPictures& scratch() { return scratch_; }

  // Calls body(i) for i in [0, count) on all threads; returns when all are done. body must not throw.
  template <class Body>
  void for_each(int count, Body&& body) {
    run(
        count, [](void* context, int i) { (*static_cast<std::remove_reference_t<Body>*>(context))(i); },
        &body);
  }

  // Calls body(y0, y1) for consecutive bands of rows of a fixed height that does not depend on the threads.
  template <class Body>
  void for_rows(int rows, Body&& body) {
    constexpr int kBand = 16;
    for_each((rows + kBand - 1) / kBand, [&](int band) {
      const int y0 = band * kBand;
      body(y0, y0 + kBand < rows ? y0 + kBand : rows);
    });
  }

 private:
  using Call = void (*)(void*, int);
  void run(int count, Call call, void* context);
  void work();
  void serve();

  ScratchPictures scratch_;
  std::vector<std::thread> threads_;
  std::mutex mutex_;
  std::condition_variable wake_, done_;
  Call call_ = nullptr;
  void* context_ = nullptr;
  int count_ = 0;
  std::atomic<int> next_{0};
  unsigned generation_ = 0;
  int busy_ = 0;
  bool running_ = false, stop_ = false;
};

}  // namespace hdrcam
