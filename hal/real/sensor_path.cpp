#include "hal/real/sensor_path.h"

#include <linux/v4l2-subdev.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>

#include "hal/pixel_format_table.h"
#include "hal/real/v4l2_formats.h"
#include "hal/real/v4l2_modes.h"

namespace hdrcam {
namespace {

// A mode for each size in which the sensor sends the format of `mode`; of a range, which has no steps here,
// as of a node that scales.
std::vector<StreamMode> in_sizes_of(const DeviceNode& sensor, std::uint32_t pad, const StreamMode& mode) {
  std::vector<StreamMode> modes;
  v4l2_subdev_frame_size_enum size{};
  size.pad = pad, size.code = bus_code_of(mode.format), size.which = V4L2_SUBDEV_FORMAT_ACTIVE;
  if (size.code == 0) return modes;
  for (; sensor.ask(VIDIOC_SUBDEV_ENUM_FRAME_SIZE, &size) == 0; ++size.index)
    for (const PixelSize& one :
         sizes_within({size.min_width, size.max_width, 1, size.min_height, size.max_height, 1}))
      modes.push_back(
          {mode.format, static_cast<int>(one.width), static_cast<int>(one.height), mode.frame_duration});
  return modes;
}

}  // namespace

std::vector<StreamMode> modes_of_sensor(const DeviceNode& sensor, std::uint32_t pad,
                                        const std::vector<StreamMode>& of_receiver) {
  std::vector<StreamMode> modes;
  std::vector<PixelFormat> done;
  bool lists_sizes = false;
  for (const StreamMode& mode : of_receiver) {
    const bool raw = packing_of(mode.format).layout != PixelLayout::Rgb;
    if (!raw) modes.push_back(mode);
    if (!raw || std::ranges::find(done, mode.format) != done.end()) continue;
    done.push_back(mode.format);
    const auto sent = in_sizes_of(sensor, pad, mode);
    lists_sizes |= !sent.empty();
    modes.insert(modes.end(), sent.begin(), sent.end());
  }
  return lists_sizes ? modes : of_receiver;
}

Result<StreamMode> set_format_along(const std::vector<SubdevicePad>& path, const StreamMode& wanted) {
  StreamMode mode = wanted;
  if (bus_code_of(mode.format) == 0) return mode;
  for (const SubdevicePad& pad : path) {
    const auto node = TRY(DeviceNode::open(pad.node));
    v4l2_subdev_format format{};
    format.which = V4L2_SUBDEV_FORMAT_ACTIVE, format.pad = pad.index;
    format.format.width = static_cast<std::uint32_t>(mode.width);
    format.format.height = static_cast<std::uint32_t>(mode.height);
    format.format.code = bus_code_of(mode.format), format.format.field = V4L2_FIELD_NONE;
    const int code = node.ask(VIDIOC_SUBDEV_S_FMT, &format);
    if (code == EPERM) return wanted;  // a read-only node: the receiver sets it when it gets its own format
    if (code != 0) return device_error(code, node.path(), "take the picture format");
    if (&pad != &path.front()) continue;
    mode.width = static_cast<int>(format.format.width), mode.height = static_cast<int>(format.format.height);
  }
  return mode;
}

}  // namespace hdrcam
