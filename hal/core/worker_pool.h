// A fixed set of threads for data-parallel loops. The work of each index does not depend on the thread that
// takes it, so a result never depends on the number of threads; reductions run over a fixed partition, not
// per thread. Each thread has a part of the indices, the same in every loop, and helps the others once it is
// done: loops over the rows of pictures then find in a thread's caches what it left there in the loop before.
// Thread-bound: one thread owns the pool and calls for_each; nested calls run in place. Who works on a pool
// works alone, so the pool also holds the pictures that such work needs meanwhile.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <mutex>
#include <thread>
#include <type_traits>
#include <vector>

#include "hal/core/scratch_pictures.h"
#include "hal/core/thread_priority.h"

namespace hdrcam {

class WorkerPool {
 public:
  // threads: 1.. ; the calling thread is one of them. Where the system allows no more, there are fewer.
  // priority: of the threads that it starts.
  explicit WorkerPool(int threads, ThreadPriority priority = ThreadPriority::Usual);
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  int threads() const { return static_cast<int>(threads_.size()) + 1; }
  ScratchPictures& scratch() { return scratch_; }

  // Calls body(i) for i in [0, count) on all threads, the first ones on the calling thread; returns when all
  // are done. What body throws, on whichever thread, is thrown here once no thread works on the loop any
  // more; other indices may then be left out.
  template <class Body>
  void for_each(int count, Body&& body) {
    run(
        count, [](void* context, int i) { (*static_cast<std::remove_reference_t<Body>*>(context))(i); },
        &body);
  }

  // Rows are worked through in bands of a fixed height that does not depend on the threads: what a row leaves
  // for the next stays in the cache of its thread.
  static constexpr int kBandRows = 16;
  static int bands_of(int rows) { return (rows + kBandRows - 1) / kBandRows; }

  // Calls body(y0, y1) for consecutive bands.
  template <class Body>
  void for_rows(int rows, Body&& body) {
    for_each(bands_of(rows), [&](int band) {
      const int y0 = band * kBandRows;
      body(y0, y0 + kBandRows < rows ? y0 + kBandRows : rows);
    });
  }
  // Calls body(band, y) for all rows; those of a band one after the other. For what needs lines of its own.
  template <class Body>
  void for_rows_of_bands(int rows, Body&& body) {
    for_rows(rows, [&](int y0, int y1) {
      for (int y = y0; y < y1; ++y) body(y0 / kBandRows, y);
    });
  }

 private:
  using Call = void (*)(void*, int);
  void run(int count, Call call, void* context);
  // The indices of a thread that are left: the first in the low half, one behind the last in the high half.
  struct alignas(64) Part {
    std::atomic<std::uint64_t> left{0};
  };
  void share_out(int count);
  void work(std::size_t thread);
  void serve(std::size_t thread);

  ScratchPictures scratch_;
  std::vector<Part> parts_;  // of the calling thread, then of the others
  std::vector<std::thread> threads_;
  std::mutex mutex_;
  std::condition_variable wake_, done_;
  Call call_ = nullptr;
  void* context_ = nullptr;
  unsigned generation_ = 0;
  int busy_ = 0;
  std::exception_ptr thrown_;  // by the body
  bool running_ = false, stop_ = false;
};

}  // namespace hdrcam
