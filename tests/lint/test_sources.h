// The sources of all tests as one text, for checks that a test which is named exists. Include last: it brings
// Catch2.
#pragma once

#include <filesystem>
#include <regex>
#include <string>

#include "tests/places.h"

#include "tests/support/files.h"

namespace hdrcam::test {

// C++ text with the string literals joined that the compiler joins.
inline std::string with_joined_literals(const std::string& text) {
  static const std::regex kSeam("\"[ \t]*\n[ \t]*\"");
  return std::regex_replace(text, kSeam, "");
}

inline std::string sources_of_tests() {
  std::string sources;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(std::filesystem::path(HDRCAM_SOURCE_DIR) / "tests"))
    if (entry.path().extension() == ".cpp") sources += with_joined_literals(text_of(entry.path()));
  return sources;
}

inline bool has_test(const std::string& sources, const std::string& name) {
  return sources.find('"' + name + '"') != std::string::npos;
}

}  // namespace hdrcam::test
