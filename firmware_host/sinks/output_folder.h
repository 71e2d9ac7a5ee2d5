// The folder that an output goes into. Reentrant.
#pragma once

#include <filesystem>
#include <string>

#include "hal/core/result.h"
#include "hal/storage.h"

namespace hdrcam {

// Creates the folder of a file where it is missing.
inline Result<void> make_folder_of(Storage& storage, const std::string& path) {
  const auto folder = std::filesystem::path(path).parent_path();
  return folder.empty() ? Result<void>{} : storage.make_directories(folder.string());
}

}  // namespace hdrcam
