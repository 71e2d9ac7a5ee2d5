#include "firmware_host/commands/no_snapshot.h"

#include <fmt/format.h>

#include "firmware_host/film/scene_snapshot.h"

namespace hdrcam {

Result<void> check_no_snapshot(Storage& storage, const std::string& file) {
  const FileKind kind = TRY(storage.look_at(file)).kind;
  if (kind == FileKind::Missing) return Error{ErrorCode::NotFound, fmt::format("'{}' does not exist", file)};
  const bool is_regular = kind == FileKind::Regular;  // a FIFO may have no writer
  if (!is_regular || !TRY(is_scene_snapshot(storage, file))) return {};
  return Error{ErrorCode::NotRecording,
               fmt::format("'{}' is a snapshot of a scene, not a recording; 'hdrcam render' films it", file)};
}

}  // namespace hdrcam
