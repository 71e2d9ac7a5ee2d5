// How an exposure is set on a V4L2 device: which controls, on which node, and the unit of one step.
//   sensor sub-device   V4L2_CID_EXPOSURE (lines), V4L2_CID_ANALOGUE_GAIN (codes), V4L2_CID_VBLANK
//   USB camera          V4L2_CID_EXPOSURE_ABSOLUTE in 100 us, V4L2_CID_GAIN
//   named by the user   any integer control of the capture node, with a unit
// Thread-compatible.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hal/camera.h"
#include "hal/real/device_node.h"
#include "hal/real/known_sensors.h"

struct v4l2_control;  // of the kernel

namespace hdrcam {

// For a driver whose exposure is a control of its own.
struct PrivateExposureControl {
  std::uint32_t id = 0;
  Duration unit = std::chrono::microseconds(100);
};

class ExposureControl {
 public:
  // Of a sensor behind a media graph. `sensor` outlives this.
  static ExposureControl of_sensor(const DeviceNode& sensor, const std::string& name);
  // Of the capture node itself. `video` outlives this.
  static ExposureControl of_video_node(const DeviceNode& video);
  static ExposureControl of_private(const DeviceNode& video, const PrivateExposureControl& control);

  bool exists() const { return exposure_.id != 0; }
  // Switches automatic exposure, gain, white balance and frame rate off.
  Result<void> take_over();
  // Puts back what it found at the first take_over(), as far as the device takes it, and until one times out:
  // a USB camera keeps its controls when it is closed, and the next program expects them as they were.
  void give_back();
  // Sets a constant frame duration on a sensor; the picture is `width` x `height` pixels. Returns the
  // resulting duration.
  Result<std::optional<Duration>> fix_frame_duration(int width, int height, Duration wanted);
  // The read-out time (CapturedBuffer) of a picture with so many rows, once the frame duration is fixed; zero
  // where the shutter is global, or is not known to be rolling.
  Duration readout(int height) const;
  // The limits and steps as they are now.
  void describe(CameraCapabilities& camera) const;
  // Writes the controls now, or into a media request; a few times where the transfer to the device fails. Of
  // two controls one may have been set where it fails. No allocation unless it fails.
  Result<void> write(const ExposureRequest& wanted, int request_fd = -1) const;
  struct Applied {
    Duration exposure{0};
    double analogue_gain = 1;
  };
  // The exposure of a completed media request; nullopt where the driver does not report it.
  std::optional<Applied> read(int request_fd) const;

 private:
  struct Control {
    std::uint32_t id = 0;                     // 0: the device has none that can be set
    std::int64_t min = 0, max = 0, step = 1;  // max: whole steps above min
  };
  explicit ExposureControl(const DeviceNode& node) : node_(&node) {}
  Control query(std::uint32_t id) const;
  void take_gain(std::uint32_t id, const std::string& sensor);
  std::optional<std::int64_t> value(std::uint32_t id) const;
  std::string name_of(std::uint32_t id) const;
  // `control` becomes as the driver set it. `doing` completes "refused to ...".
  Result<void> set(v4l2_control& control, const char* doing) const;
  std::optional<double> line_ns(std::int64_t width) const;  // of a sensor; nullopt where it does not say

  struct Found {
    std::uint32_t id;
    std::int32_t value;
  };

  const DeviceNode* node_;
  Control exposure_, gain_;
  std::vector<Found> found_;  // before take_over(), in the order in which they are put back
  double unit_ns_ = 1;        // of one step of the exposure control
  GainCodes gain_codes_;
  Shutter shutter_ = Shutter::Unknown;
  bool sensor_ = false;
};

}  // namespace hdrcam
