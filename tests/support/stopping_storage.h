// The disk of a program that is told to stop in the middle of its work: a signal that comes while the n-th
// file of some name is made. Thread-bound, but for stop().
#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "hal/fault/faulty_storage.h"

namespace hdrcam::test {

class StoppingStorage : public FaultyStorage {
 public:
  // Counts the files whose paths hold these words; the one that is number `file`, from 1 on, is the signal.
  StoppingStorage(std::string words, int file)
      : FaultyStorage(posix_storage(), {}), words_(std::move(words)), left_(file) {}

  Result<std::unique_ptr<StorageFile>> create(const std::string& path, Creation how) override {
    if (path.find(words_) != std::string::npos && --left_ == 0) stop_ = true;
    return FaultyStorage::create(path, how);
  }
  const std::atomic<bool>& stop() const { return stop_; }

 private:
  const std::string words_;
  std::atomic<int> left_;
  std::atomic<bool> stop_{false};
};

}  // namespace hdrcam::test
