#include "capture/control_history.h"

#include <algorithm>

namespace hdrcam {

void ControlHistory::sent(const ExposureRequest& controls, int slot) {
  requests_[controls.cookie % kRequests] = {controls, slot, false, std::nullopt};
}

void ControlHistory::queued(std::uint64_t cookie, Instant at) {
  if (auto& request = requests_[cookie % kRequests]; request && request->controls.cookie == cookie)
    request->queued = at;
}

std::optional<Instant> ControlHistory::queued_at(std::uint64_t cookie) const {
  const auto& request = requests_[cookie % kRequests];
  return request && request->controls.cookie == cookie ? request->queued : std::nullopt;
}

bool ControlHistory::completed(std::uint64_t frame, std::uint64_t cookie, bool late,
                               const BegunSince& begun) {
  const bool repeated = highest_cookie_ && cookie <= *highest_cookie_;
  highest_cookie_ = repeated ? *highest_cookie_ : cookie;
  if (auto& request = requests_[cookie % kRequests]; request && request->controls.cookie == cookie)
    request->late = late;
  const std::uint64_t due = std::clamp<std::uint64_t>(frame - newest_frame_, 1, kFrames);
  const std::optional<std::uint64_t> before = cookies_[newest_frame_ % kFrames];
  for (std::uint64_t back = 0; back < due; ++back) {
    std::optional<std::uint64_t>& written = cookies_[(frame - back) % kFrames];
    written.reset();
    if (repeated) continue;
    if (back < begun.surely) written = cookie;
    if (back >= begun.perhaps) written = before;
  }
  newest_frame_ = frame;
  return !repeated;
}

const ControlHistory::Request* ControlHistory::written_at(std::int64_t frame) const {
  const auto newest = static_cast<std::int64_t>(newest_frame_);
  if (frame < 0 || newest - frame >= kFrames) return nullptr;
  const auto& known = cookies_[static_cast<std::uint64_t>(std::min(frame, newest)) % kFrames];
  if (!known) return nullptr;
  const std::uint64_t cookie = *known + static_cast<std::uint64_t>(std::max<std::int64_t>(0, frame - newest));
  const auto& request = requests_[cookie % kRequests];
  return request && request->controls.cookie == cookie ? &*request : nullptr;
}

}  // namespace hdrcam
