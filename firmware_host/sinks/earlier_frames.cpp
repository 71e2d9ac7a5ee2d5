#include "firmware_host/sinks/earlier_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "firmware_host/sinks/frame_pattern.h"
#include "firmware_host/sinks/sink_table.h"
#include "hal/core/counted.h"
#include "hal/core/folder_listing.h"

namespace hdrcam {

EarlierFrames::EarlierFrames(Storage& storage, const std::string& pattern)
    : storage_(storage), pattern_(pattern) {
  const std::filesystem::path as_path(pattern);
  const auto parsed = FramePattern::parse("", pattern, as_path.extension().string());
  if (!parsed) return;
  const FolderListing listing(parsed.value().folder());
  for (const std::filesystem::path& entry : listing.paths()) {
    const std::filesystem::path name = entry.filename();
    if (!parsed.value().fits(name.string())) continue;
    const std::string path = (as_path.parent_path() / name).string();  // with the folder as it was given
    if (const auto facts = storage.look_at(path)) files_.push_back({path, facts.value()});
  }
  if (listing.failure() && !listing.is_missing()) listed_ = listing.cannot_read();
  std::ranges::sort(files_, {}, &File::path);
}

// A file that was replaced is another one of the same name (FileInMaking).
bool EarlierFrames::remains(const File& file) const {
  const auto now = storage_.look_at(file.path);
  return now && now.value().kind != FileKind::Missing && same_file(now.value(), file.facts);
}

bool EarlierFrames::remains(const std::string& path) const {
  const std::filesystem::path name = std::filesystem::path(path).filename();
  const std::string known = (std::filesystem::path(pattern_).parent_path() / name).string();
  const auto file = std::ranges::lower_bound(files_, known, {}, &File::path);
  return file != files_.end() && file->path == known && remains(*file);
}

std::optional<std::string> EarlierFrames::first_new() const {
  const EarlierFrames now(storage_, pattern_);
  const auto came =
      std::ranges::find_if(now.files_, [this](const File& file) { return !remains(file.path); });
  return came == now.files_.end() ? std::nullopt : std::optional(came->path);
}

Result<void> EarlierFrames::check_none_came() const {
  const auto came = first_new();
  if (!came) return {};
  return Error{
      ErrorCode::Exists,
      fmt::format("'{}' was written by another program meanwhile; it stays, and this run has none of "
                  "'{}'; name other files",
                  *came, pattern_)};
}

std::string EarlierFrames::warning() const {
  if (!listed_)
    return fmt::format("{}; whether files of an earlier run remain there is not known",
                       listed_.error().message);
  std::vector<std::string> left;
  for (const File& file : files_)
    if (remains(file)) left.push_back(file.path);
  if (left.empty() || !first_new()) return "";
  return fmt::format(
      "{} of an earlier run {} beside the new ones, from '{}' to '{}'; remove them "
      "before '{}' is read as one clip",
      counted(left.size(), "file"), left.size() == 1 ? "remains" : "remain", left.front(), left.back(),
      pattern_);
}

std::vector<EarlierFrames> earlier_frames(Storage& storage, std::span<const SinkKind> kinds,
                                          const OutputPaths& paths) {
  std::vector<EarlierFrames> earlier;
  for (const SinkKind& kind : kinds) {
    const auto path = paths.find(kind.name);
    if (kind.extension != nullptr && path != paths.end()) earlier.emplace_back(storage, path->second);
  }
  return earlier;
}

}  // namespace hdrcam
