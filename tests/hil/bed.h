// The devices of the guest: nodes by name, GPIO lines from their other end, USB cameras that are plugged in
// and out.
#pragma once

#include <sys/types.h>

#include <string>
#include <string_view>

#include "hal/camera.h"

namespace hdrcam::hil {

// "/dev/video2" of the first capture node whose name contains `part`; fails the test where none comes within
// seconds.
std::string video_node(std::string_view part);

// A line of the simulated GPIO chip, seen from outside the processor.
class SimulatedPin {
 public:
  explicit SimulatedPin(int line);
  void drive(bool high) const;  // of an input
  bool level() const;           // of an output
  const std::string& pull_file() const { return pull_; }

 private:
  std::string pull_, value_;
};

// A simulated USB camera in its own process; it is unplugged when it goes out of scope.
class UsbCamera {
 public:
  // latency: frames from a setting to the picture that shows it. rate: unless the host asks for another. Of
  // every `lose_every` frames the last is exposed but never sent; 0: all are sent.
  explicit UsbCamera(int latency_frames, int rate_hz = 30, std::string_view strobe_file = "",
                     int lose_every = 0);
  ~UsbCamera();
  UsbCamera(const UsbCamera&) = delete;
  UsbCamera& operator=(const UsbCamera&) = delete;

  void unplug();
  std::string node() const { return video_node(name_); }
  const std::string& name() const { return name_; }

 private:
  std::string name_;
  pid_t process_ = -1;
};

// Mean of the luma (YUYV) or of the 16-bit words (unpacked Bayer) or of the bytes (all else), below the
// middle of the picture: drivers write text above, at full brightness whatever the exposure.
double mean_code(const CapturedBuffer& buffer);

}  // namespace hdrcam::hil
