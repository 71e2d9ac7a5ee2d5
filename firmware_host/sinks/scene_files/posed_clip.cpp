#include "firmware_host/sinks/scene_files/posed_clip.h"

#include <fmt/format.h>

#include <filesystem>

namespace hdrcam {

namespace fs = std::filesystem;

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
