// The disk of a program that is told to stop in the middle of its work: a signal that comes as soon as the
// n-th file of some name is complete. Thread-bound, but for stop().
#pragma once

#include <atomic>
#include <string>

#include "hal/fault/faulty_storage.h"

namespace hdrcam::test {

class StoppingStorage : public FaultyStorage {
 public:
  // Counts the files that get a path with these words; the one that is number `file`, from 1 on, is the
  // signal.
  StoppingStorage(std::string words, int file)
      : FaultyStorage(posix_storage(), {}), words_(std::move(words)), left_(file) {}

  Result<void> rename(const std::string& from, const std::string& to, Creation how) override {
    const Result<void> renamed = FaultyStorage::rename(from, to, how);
    if (renamed && to.find(words_) != std::string::npos && --left_ == 0) stop_ = true;
    return renamed;
  }
  const std::atomic<bool>& stop() const { return stop_; }

 private:
  const std::string words_;
  std::atomic<int> left_;
  std::atomic<bool> stop_{false};
};

}  // namespace hdrcam::test
