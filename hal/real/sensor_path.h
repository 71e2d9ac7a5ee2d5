// A sensor behind a receiver that leaves the formats between them to the program (V4L2_CAP_IO_MC): what such
// a receiver lists is what it could take from any sensor. Reentrant.
#pragma once

#include <cstdint>
#include <vector>

#include "hal/camera.h"
#include "hal/real/device_node.h"
#include "hal/real/media_graph.h"

namespace hdrcam {

// The modes of the receiver that this sensor sends from this pad: raw ones in its formats and sizes. Others,
// which something between them makes, and all where the sensor lists nothing, stay as the receiver lists
// them.
std::vector<StreamMode> modes_of_sensor(const DeviceNode& sensor, std::uint32_t pad,
                                        const std::vector<StreamMode>& of_receiver);

// Sets the picture's format on every pad between the sensor and the receiver, which starts only if they
// agree. Returns the mode in the size that the sensor took, the nearest that it has. Receivers that set these
// formats themselves make the nodes read-only (V4L2_SUBDEV_CAP_RO_SUBDEV): the mode stays as it is.
Result<StreamMode> set_format_along(const std::vector<SubdevicePad>& path, const StreamMode& wanted);

}  // namespace hdrcam
