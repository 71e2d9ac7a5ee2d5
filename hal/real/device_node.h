// An open node under /dev, and the error texts for the kernel's answers: which process holds a busy device,
// which group may open it, that it was unplugged. Thread-compatible.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hal/core/instant.h"
#include "hal/core/result.h"
#include "hal/descriptor.h"

namespace hdrcam {

class DeviceNode {
 public:
  // Opens for reading and writing, never blocking. NotFound, Permission, Busy, Unplugged.
  static Result<DeviceNode> open(const std::string& path);

  int fd() const { return fd_.get(); }
  const std::string& path() const { return path_; }

  // Repeats ioctl() while it is interrupted. Returns 0 or the errno.
  int ask(unsigned long request, void* argument) const;
  // The same as a Result; `doing` completes "cannot ... ": "start the stream".
  Result<void> demand(unsigned long request, void* argument, const char* doing) const;

 private:
  DeviceNode(Descriptor fd, std::string path) : fd_(std::move(fd)), path_(std::move(path)) {}

  Descriptor fd_;
  std::string path_;
};

// What to do about some of these errors. The cable is that of a USB camera or the ribbon of a sensor's board,
// which is not made to be plugged while it has power.
inline constexpr const char* kCheckCable =
    "check its cable and hub; plug a USB camera in again, a ribbon cable only with the power off";
inline constexpr const char* kNoBandwidth =
    "the USB bus has no bandwidth left for it; choose a smaller size, a lower frame rate or MJPEG, or plug "
    "it into another bus";

// The Error for an errno that the device answered while `doing` something with it.
Error device_error(int code, const std::string& path, const std::string& doing);

// The same of a control of a device that is in use by us: that it is busy or stalled says nothing of others.
Error control_error(int code, const std::string& path, const std::string& doing);

// Whether this errno says that a transfer over the bus failed; the device usually takes the next one.
bool is_failed_transfer(int code);
// The same, or that it took too long, or that the bus was shut down.
bool is_of_bus(int code);

// The nodes whose names begin so, such as "video": "/dev/video0" first, and 2 before 10.
std::vector<std::string> device_nodes(std::string_view beginning);

// Why the first of these nodes that this user may not open is closed: Permission, and how to get it. nullopt
// where all may be opened, or are none.
std::optional<Error> closed_node(const std::vector<std::string>& nodes);

// "'name' (process 123)" of another process of this user that has the node open; empty where none can be
// seen.
std::string holder_of(const std::string& path);

// Like "add this user to the group 'video' and log in again", from the owner and mode of the node.
std::string how_to_get_permission(const std::string& path);

// An event that one thread sets, and for which another sleeps together with a device. Thread-safe.
class WakeUp {
 public:
  WakeUp();

  void set();
  void clear();

  // What poll() says of the two (`revents`); 0: nothing.
  struct Ready {
    short woken = 0, device = 0;
  };
  // Sleeps until the event is set, the device has something to read or fails, or the time is over; perhaps
  // shorter, where a signal comes. device: its file descriptor; -1: only the event.
  Ready sleep(int device, Duration at_most) const;

 private:
  const Descriptor fd_;
};

}  // namespace hdrcam
