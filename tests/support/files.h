// Whole files, read and written. Include it last: it brings Catch2.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "hal/storage.h"
#include "tests/contracts/expect.h"

namespace hdrcam::test {

inline std::string text_of(const std::filesystem::path& path) {
  return value_of(read_whole(posix_storage(), path.string()));
}

// In place: a link or a device stays one.
inline void write_file(const std::filesystem::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  INFO(path.string());
  REQUIRE(file.good());
}

}  // namespace hdrcam::test
