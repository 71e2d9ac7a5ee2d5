// The modes of a V4L2 capture node, and the choice of one of them. Single-planar and multi-planar queues work
// alike, as long as a picture lies in one piece of memory. Reentrant.
#pragma once

#include <cstdint>
#include <vector>

#include "hal/camera.h"
#include "hal/real/device_node.h"

struct v4l2_frmsize_stepwise;  // of the kernel

namespace hdrcam {

struct V4l2Identity {
  std::string card, driver, bus;
  std::uint32_t queue_type = 0;   // V4L2_BUF_TYPE_VIDEO_CAPTURE or _MPLANE; 0: not a camera
  bool media_controlled = false;  // formats are set along a media graph (V4L2_CAP_IO_MC)
  bool takes_signal = false;      // its input is a video signal, as that of a capture card
};
Result<V4l2Identity> identify(const DeviceNode& video);
// Whether its formats or its exposure can be set on nodes of a media graph only. A USB camera has all that it
// lets be set on its capture node, also where its exposure is fixed; a loopback likewise. A capture card has
// no sensor. PCI tells nothing: image processors with sensors are on that bus, too.
bool needs_sensor_node(const V4l2Identity& identity, const CameraCapabilities& camera);

struct PixelSize {
  std::uint32_t width, height;
};
// Of a range: the usual size, where it is within the range and not its end, and the largest.
std::vector<PixelSize> sizes_within(const v4l2_frmsize_stepwise& range);

// All modes in the supported formats, each with its shortest frame duration (33.3 ms where the driver reports
// none). Of sizes that have no list but a range: sizes_within() it.
std::vector<StreamMode> modes_of(const DeviceNode& video, std::uint32_t queue_type);

struct V4l2Picture {
  StreamMode mode;
  YuvCoding yuv;                      // of YUV formats
  std::size_t stride = 0, bytes = 0;  // of a row (0: compressed), of a whole picture
};
// Sets the nearest mode that the driver accepts. Unsupported for another format, naming the offered ones, and
// where pictures are interlaced.
Result<V4l2Picture> set_mode(const DeviceNode& video, std::uint32_t queue_type, const StreamMode& wanted);

}  // namespace hdrcam
