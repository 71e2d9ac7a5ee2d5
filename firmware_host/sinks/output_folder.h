// The folder that an output goes into. Reentrant.
#pragma once

#include <filesystem>
#include <string>

#include "hal/core/result.h"
#include "hal/storage.h"

namespace hdrcam {

// The folder of a file; "." where its name has none.
inline std::string folder_of(const std::string& path) {
  const auto folder = std::filesystem::path(path).parent_path();
  return folder.empty() ? "." : folder.string();
}

// Creates the folder of a file where it is missing.
inline Result<void> make_folder_of(Storage& storage, const std::string& path) {
  const auto folder = std::filesystem::path(path).parent_path();
  return folder.empty() ? Result<void>{} : storage.make_directories(folder.string());
}

}  // namespace hdrcam
