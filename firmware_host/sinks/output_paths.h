// Where a run writes: the path of each output, by the name of its sink (sink_name.h) or of the saved scene
// (Settings::Output::kSnapshot). Plain values; reentrant.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>

namespace hdrcam {

// "" or missing: not wanted.
using OutputPaths = std::map<std::string, std::string, std::less<>>;

// "" where it is not wanted. Valid as long as the paths are.
inline const std::string& path_in(const OutputPaths& paths, std::string_view output) {
  static const std::string none;
  const auto found = paths.find(output);
  return found == paths.end() ? none : found->second;
}

}  // namespace hdrcam
