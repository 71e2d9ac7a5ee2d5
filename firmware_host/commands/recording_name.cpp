#include "firmware_host/commands/recording_name.h"

#include <fmt/format.h>

#include "hal/core/counted.h"
#include "hal/video/video_writer.h"

namespace hdrcam {

Result<void> check_recording_name(Storage& storage, const char* flag, const std::string& path) {
  if (path.empty() || video_container_of(path) == VideoContainer::Matroska) return {};
  if (TRY(storage.look_at(path)).kind == FileKind::Other) return {};
  return Error{
      ErrorCode::Invalid,
      fmt::format("{} '{}' is not the name of a recording, which is a Matroska file; name it like walk.mkv",
                  flag, path)};
}

std::string describe_recording(const std::string& path, const CameraFacts& camera, std::uint64_t frames) {
  return fmt::format("{}: {}, {}x{}, {} bits, {}", path, counted(frames, "frame"), camera.width,
                     camera.height, camera.bits, name(camera.layout));
}

}  // namespace hdrcam
