// What becomes of an exposure that a device did not take. A USB camera fails a control transfer now and then
// (a stall, a bus error, "not ready") and takes the next one: its frame goes without its exposure, which the
// ControlPacer tells, and the run goes on. One that takes none for many frames ends it. Thread-compatible.
#pragma once

#include <cerrno>
#include <cstdint>

#include "hal/core/result.h"
#include "hal/real/device_node.h"

namespace hdrcam {

class ControlRefusals {
 public:
  static constexpr int kMostInARow = 30;       // frames
  static constexpr int kFramesOfTimeout = 10;  // one counts for so many: it takes seconds

  void restart() { *this = {}; }

  // What the device answered to the exposure of the frame with this index. Its error, where it will not pass
  // or went on for too many frames.
  Result<void> answered(std::uint64_t frame, const Result<void>& wrote) {
    if (wrote) return frames_ = 0, wrote;
    const int code = wrote.error().sys_errno;
    if (!may_pass(code)) return wrote;
    if (frames_ == 0 || frame != last_) frames_ += code == ETIMEDOUT ? kFramesOfTimeout : 1, last_ = frame;
    if (frames_ < kMostInARow) return {};
    Error error = wrote.error();
    error.message += ", again and again; plug the camera in again, or check its cable";
    return error;
  }

 private:
  // Of the bus, rather than of the value.
  static bool may_pass(int code) {
    return is_failed_transfer(code) || code == EBUSY || code == EAGAIN || code == ETIMEDOUT ||
           code == ESHUTDOWN;
  }

  int frames_ = 0;          // in a row
  std::uint64_t last_ = 0;  // of them
};

}  // namespace hdrcam
