// A storage that passes everything on and remembers what a run made on it: whether it wrote a file, and which
// folders it made, so that a run that failed leaves no empty ones. Thread-safe, as the storage behind it.
#pragma once

#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "hal/forwarding_storage.h"

namespace hdrcam {

class NotingStorage final : public ForwardingStorage {
 public:
  using ForwardingStorage::ForwardingStorage;
  bool written() const { return written_; }

  Result<std::unique_ptr<StorageFile>> create(const std::string& path, Creation how) override {
    written_ = true;
    return ForwardingStorage::create(path, how);
  }
  Result<void> make_directories(const std::string& path) override {
    std::vector<std::string> missing;
    for (std::filesystem::path folder = path; !folder.empty() && !is_there(inner_, folder.string());
         folder = folder.parent_path())
      missing.push_back(folder.string());
    {
      const std::lock_guard lock(mutex_);
      made_.insert(made_.end(), missing.rbegin(), missing.rend());
    }
    return ForwardingStorage::make_directories(path);
  }

  // Of those that it made. A folder that holds something stays, and so does what is no folder: a link to one
  // that is not there, as on a disk that is not mounted, could not become one.
  void remove_empty_folders() {
    const std::lock_guard lock(mutex_);
    for (auto folder = made_.rbegin(); folder != made_.rend(); ++folder) (void)::rmdir(folder->c_str());
    made_.clear();
  }

 private:
  std::atomic<bool> written_{false};
  std::mutex mutex_;
  std::vector<std::string> made_;  // the outer ones first
};

}  // namespace hdrcam
