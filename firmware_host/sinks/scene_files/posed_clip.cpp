#include "firmware_host/sinks/scene_files/posed_clip.h"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

namespace hdrcam {

namespace fs = std::filesystem;

PosedPicture posed_picture(std::string path, const FrameFacts& facts, Instant start,
                           const RigidTransform& T_world_camera) {
  PosedPicture picture{.path = std::move(path),
                       .depth_path = "",
                       .time_s = to_seconds(facts.timestamp - start),
                       .T_world_camera = T_world_camera};
  if (facts.has_exposure_time()) picture.exposure_s = facts.exposure_s;
  return picture;
}

std::string path_from(const std::string& folder, const std::string& path) {
  std::error_code failed;
  const fs::path from = fs::absolute(folder, failed).lexically_normal();
  const fs::path to = fs::absolute(path, failed).lexically_normal();
  const fs::path relative = to.lexically_relative(from);
  return failed || relative.empty() ? path : relative.generic_string();
}

Result<void> check_lens(PoseSource source, bool lens_is_assumed, const std::string& clip) {
  if (source != PoseSource::Given || !lens_is_assumed) return {};
  return Error{
      ErrorCode::Invalid,
      fmt::format("{} has poses but states no lens, and poses mean nothing without the lens that they "
                  "were made with; import it with fx, fy, cx and cy in its clip.json, or "
                  "track the camera: hdrcam replay with --set pose=tracked",
                  clip)};
}

}  // namespace hdrcam
