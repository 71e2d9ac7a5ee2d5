// The Error for what libcamera answers about a camera, which is an errno below 0. Reentrant.
#pragma once

#include <cerrno>
#include <cstring>
#include <string>

#include "hal/core/result.h"
#include "hal/real/device_node.h"

namespace hdrcam {

// doing: completes "cannot ... ".
inline Error libcamera_error(int code, const std::string& id, const char* doing) {
  switch (-code) {
    case EBUSY:
      return {ErrorCode::Busy,
              fmt::format("camera '{}' is in use by another program; stop it or choose another camera", id),
              EBUSY};
    case EACCES:
    case EPERM:
      return {ErrorCode::Permission,
              fmt::format(
                  "no permission for camera '{}'; add this user to the group 'video' and log in again", id),
              -code};
    case ENODEV:
      return {ErrorCode::Unplugged, fmt::format("camera '{}' was unplugged", id), ENODEV};
    case ENOSPC:
      return {ErrorCode::Io, fmt::format("camera '{}' cannot {}: {}", id, doing, kNoBandwidth), ENOSPC};
    default:
      return {ErrorCode::Io,
              fmt::format("camera '{}' cannot {}: {}{}", id, doing, std::strerror(-code),
                          is_of_bus(-code) ? fmt::format("; {}", kCheckCable) : ""),
              -code};
  }
}

}  // namespace hdrcam
