// What lies in a folder. Value type, reentrant.
#pragma once

#include <filesystem>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "hal/core/result.h"

namespace hdrcam {

class FolderListing {
 public:
  explicit FolderListing(std::string folder) : folder_(std::move(folder)) {
    namespace fs = std::filesystem;
    for (fs::directory_iterator entry(folder_, failure_), end; !failure_ && entry != end;
         entry.increment(failure_))
      paths_.push_back(entry->path());
  }

  // In no order; those that came before the failure, if there is one.
  const std::vector<std::filesystem::path>& paths() const { return paths_; }
  const std::error_code& failure() const { return failure_; }
  // Whether it failed because there is no such folder.
  bool is_missing() const {
    return failure_ == std::errc::no_such_file_or_directory || failure_ == std::errc::not_a_directory;
  }
  // The failure in words: Permission.
  Error cannot_read() const {
    return {ErrorCode::Permission,
            fmt::format("cannot read the folder '{}': {}", folder_, failure_.message()), failure_.value()};
  }

 private:
  std::string folder_;
  std::vector<std::filesystem::path> paths_;
  std::error_code failure_;
};

}  // namespace hdrcam
