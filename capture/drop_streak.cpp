#include "capture/drop_streak.h"

#include <fmt/format.h>

namespace hdrcam {

void DropStreak::end() {
  frames_ = 0;
  not_decoded_.reset();
}

Result<void> DropStreak::damaged(const std::string& camera) { return dropped(camera); }

Result<void> DropStreak::not_decoded(const std::string& camera, const Error& why) {
  if (!not_decoded_) not_decoded_ = why;
  if (why.code != ErrorCode::Corrupt) return why;
  return dropped(camera);
}

Result<void> DropStreak::dropped(const std::string& camera) {
  constexpr int kMostInARow = 30;
  if (++frames_ < kMostInARow) return {};
  if (!not_decoded_)
    return Error{ErrorCode::Corrupt,
                 fmt::format("{} frames of '{}' in a row were damaged: the driver reports incomplete pixels; "
                             "check the camera's cable, hub or sensor link, or choose a smaller size or "
                             "frame rate",
                             kMostInARow, camera)};
  return Error{
      ErrorCode::Corrupt,
      fmt::format("{} frames of '{}' in a row did not decode, the first for this reason: {}; choose another "
                  "pixel format or size, or check the camera's cable",
                  kMostInARow, camera, not_decoded_->message)};
}

}  // namespace hdrcam
