#include "firmware_host/sinks/earlier_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "firmware_host/sinks/frame_pattern.h"

namespace hdrcam {

EarlierFrames::EarlierFrames(Storage& storage, const std::string& pattern)
    : storage_(storage), pattern_(pattern) {
  const auto parsed = FramePattern::parse("", pattern, std::filesystem::path(pattern).extension().string());
  if (!parsed) return;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(parsed.value().folder(), ignored)) {
    const auto sequence = parsed.value().sequence_of(entry.path().filename().string());
    if (!sequence) continue;
    const std::string path = parsed.value().path(*sequence);
    if (const auto facts = storage.look_at(path)) files_.push_back({path, facts.value().inode});
  }
  std::ranges::sort(files_, {}, &File::path);
}

// A file that was replaced is another one of the same name (FileInMaking).
std::string EarlierFrames::warning() const {
  std::vector<std::string> left;
  for (const File& file : files_)
    if (const auto facts = storage_.look_at(file.path);
        facts && facts.value().kind != FileKind::Missing && facts.value().inode == file.inode)
      left.push_back(file.path);
  if (left.empty()) return "";
  return fmt::format(
      "{} file(s) of an earlier run remain beside the new ones, from '{}' to '{}'; remove them "
      "before '{}' is read as one clip",
      left.size(), left.front(), left.back(), pattern_);
}

}  // namespace hdrcam
