// Loops of a pool: every index once, each thread its own part first, and nobody waits for a slow one.
#include "hal/core/worker_pool.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <new>
#include <set>
#include <thread>
#include <vector>

#include "tests/support/refused_threads.h"

#include <catch2/catch.hpp>

using namespace hdrcam;

namespace {

// The first index that each thread takes of a loop in which none goes on before all are at work.
std::map<std::thread::id, int> first_of_each(WorkerPool& pool, int count) {
  std::map<std::thread::id, int> first;
  std::mutex mutex;
  std::condition_variable all_at_work;
  pool.for_each(count, [&](int i) {
    std::unique_lock lock(mutex);
    if (!first.emplace(std::this_thread::get_id(), i).second) return;
    all_at_work.notify_all();
    all_at_work.wait(lock, [&] { return static_cast<int>(first.size()) == pool.threads(); });
  });
  return first;
}

}  // namespace

TEST_CASE("a pool takes every index once, whatever the count and the number of threads") {
  for (const int threads : {1, 2, 3, 5}) {
    WorkerPool pool(threads);
    for (int loop = 0; loop < 200; ++loop)
      for (const int count : {0, 1, 2, 3, 7, 64}) {
        std::vector<std::atomic<int>> times(static_cast<std::size_t>(count));
        pool.for_each(count, [&](int i) { ++times[static_cast<std::size_t>(i)]; });
        for (const auto& n : times) REQUIRE(n == 1);
      }
  }
}

TEST_CASE("where the system starts no more threads a pool does with those that it has") {
  const test::RefusedThreads none;
  WorkerPool pool(5);
  CHECK(pool.threads() == 1);
  std::vector<int> times(64);
  pool.for_each(64, [&](int i) { ++times[static_cast<std::size_t>(i)]; });
  CHECK(times == std::vector<int>(64, 1));
}

TEST_CASE("a thread has the same part of the indices in every loop, the calling thread the first") {
  constexpr int kPart = 4;
  for (const int threads : {2, 3}) {
    WorkerPool pool(threads);
    const std::map<std::thread::id, int> first = first_of_each(pool, threads * kPart);
    CHECK(first.at(std::this_thread::get_id()) == 0);
    std::set<int> firsts;
    for (const auto& [thread, index] : first) firsts.insert(index);
    for (int part = 0; part < threads; ++part) CHECK(firsts.contains(part * kPart));
    for (int loop = 0; loop < 50; ++loop) REQUIRE(first_of_each(pool, threads * kPart) == first);
  }
}

TEST_CASE("what a slow thread has not begun is done by the others") {
  WorkerPool pool(2);
  constexpr int kCount = 20;
  std::atomic<int> done{0};
  std::atomic<bool> helped{true};
  pool.for_each(kCount, [&](int i) {
    if (i == 0) {  // the calling thread's first: it waits for all others, its own part among them
      const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
      while (done < kCount - 1 && helped)
        if (std::chrono::steady_clock::now() > end) helped = false;
    }
    ++done;
  });
  CHECK(helped);
  CHECK(done == kCount);
}

TEST_CASE(
    "what the body of a loop throws, on whichever thread, is thrown by the loop, and the pool goes on") {
  constexpr int kCount = 64;
  for (const int threads : {1, 3}) {
    WorkerPool pool(threads);
    for (int bad = 0; bad < kCount; ++bad) {
      const auto throw_at_one = [&] {
        pool.for_each(kCount, [&](int i) {
          if (i == bad) throw std::bad_alloc();
        });
      };
      const auto throw_at_all = [&] { pool.for_each(kCount, [](int) { throw std::bad_alloc(); }); };
      CHECK_THROWS_AS(throw_at_one(), std::bad_alloc);
      CHECK_THROWS_AS(throw_at_all(), std::bad_alloc);
      std::atomic<int> done{0};
      pool.for_each(kCount, [&](int) { ++done; });
      REQUIRE(done == kCount);
    }
  }
}

TEST_CASE("a loop in a loop runs on the thread that calls it") {
  WorkerPool pool(2);
  std::atomic<int> total{0}, elsewhere{0};
  pool.for_each(6, [&](int) {
    const std::thread::id here = std::this_thread::get_id();
    pool.for_each(5, [&](int) {
      ++total;
      if (std::this_thread::get_id() != here) ++elsewhere;
    });
  });
  CHECK(total == 30);
  CHECK(elsewhere == 0);
}
