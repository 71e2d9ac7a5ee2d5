// The extension of a file's name, by which its kind is told. Reentrant.
#pragma once

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string>

namespace hdrcam {

// With its dot, in lower case: ".jpg" of "IMG_1.JPG"; "" for none.
inline std::string lower_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

}  // namespace hdrcam
