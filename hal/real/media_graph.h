// The media controller's graph of one capture node: which sensor feeds it, through which sub-devices.
// Reentrant.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hal/core/result.h"
#include "hal/real/device_node.h"

namespace hdrcam {

// One pad of a sub-device on the way from the sensor to the capture node, or fed from it.
struct SubdevicePad {
  std::string node;  // "/dev/v4l-subdev0"
  std::uint32_t index = 0;
};

struct MediaGraph {
  std::string node;  // "/dev/media0"
  std::string sensor_name,
      sensor_node;                 // empty: the sensor is inside the driver (USB cameras) or there is none
  std::vector<SubdevicePad> path;  // in the direction of the data: sensor first
};

// nullopt where none of these media devices has the capture node. Permission where one exists that may not be
// opened.
Result<std::optional<MediaGraph>> media_graph_of(
    const std::string& video_node, const std::vector<std::string>& media_nodes = device_nodes("media"));

}  // namespace hdrcam
