#include "hal/real/control_refusals.h"

#include <cerrno>

#include "hal/real/device_node.h"

namespace hdrcam {
namespace {

bool is_held(int code) { return code == EBUSY || code == EAGAIN; }

// Others are of the value, or of the device itself.
bool may_pass(int code) { return is_held(code) || is_of_bus(code); }

std::string what_to_do(int code) {
  if (is_held(code))
    return "; stop the program that holds its controls ('hdrcam list' names one that has it open), or plug "
           "a USB camera in again";
  if (is_of_bus(code)) return fmt::format("; {}", kCheckCable);
  // the node is open, so this user may use it: the control itself takes no value now
  if (code == EACCES || code == EPERM)
    return "; another program may have switched its automatic exposure on again: stop that one";
  return "";
}

}  // namespace

Result<void> ControlRefusals::answered(std::uint64_t frame, const Result<void>& wrote, Instant now) {
  if (wrote) return frames_ = 0, wrote;
  Error error = wrote.error();
  if (may_pass(error.sys_errno)) {
    if (frames_ == 0) begun_ = now;
    if (frames_ == 0 || frame != last_) ++frames_, last_ = frame;
    if (frames_ < kFewest || now - begun_ < kLongest) return {};
    error.message += ", again and again";
  }
  error.message += what_to_do(error.sys_errno);
  return error;
}

}  // namespace hdrcam
