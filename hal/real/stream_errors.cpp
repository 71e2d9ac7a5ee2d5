#include "hal/real/stream_errors.h"

#include <chrono>
#include <cstdint>

#include "hal/real/device_node.h"

namespace hdrcam {
namespace {

std::int64_t in_ms(Duration time) {
  return std::chrono::duration_cast<std::chrono::milliseconds>(time).count();
}

}  // namespace

Error must_stop_to_configure(const std::string& id) {
  return {ErrorCode::Invalid, fmt::format("camera '{}' is started; stop it to configure it", id)};
}

Error already_started(const std::string& id) {
  return {ErrorCode::Invalid, fmt::format("camera '{}' is started already", id)};
}

Error not_configured(const std::string& id) {
  return {ErrorCode::Invalid, fmt::format("camera '{}' is not configured", id)};
}

Error not_started(const std::string& id) {
  return {ErrorCode::Invalid, fmt::format("camera '{}' is not started", id)};
}

Result<void> check_buffers(int buffers, int most) {
  if (buffers >= 1 && buffers <= most) return {};
  return Error{ErrorCode::Invalid,
               fmt::format("a stream cannot have {} buffers; ask for 1 to {}", buffers, most)};
}

Result<void> check_size(const StreamMode& wanted) {
  if (wanted.width > 0 && wanted.height > 0) return {};
  return Error{ErrorCode::Invalid,
               fmt::format("a picture of {} x {} pixels is impossible", wanted.width, wanted.height)};
}

Error stopped(const std::string& id) {
  return {ErrorCode::Interrupted, fmt::format("camera '{}' is stopped", id)};
}

Error no_frame_within(const std::string& id, Duration timeout) {
  return {ErrorCode::Timeout,
          fmt::format("camera '{}' delivered no frame within {} ms ({})", id, in_ms(timeout), kCheckCable)};
}

Error stream_fails(const std::string& id, Duration timeout) {
  return {ErrorCode::Io,
          fmt::format("camera '{}' reports that its stream failed, and delivered no frame within {} ms; run "
                      "again, {}",
                      id, in_ms(timeout), kCheckCable)};
}

}  // namespace hdrcam
