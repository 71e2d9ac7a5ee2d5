// Known sensors: after how many frames their controls act, and the black level of their raw codes. The table
// names them as drivers name cameras. hal/real/known_sensors.h is another table, for V4L2 alone: what a
// sensor's gain codes mean and the kind of its shutter. Reentrant.
#pragma once

#include <optional>
#include <string_view>

#include "hal/camera.h"
#include "hal/core/black_level.h"

namespace hdrcam {

struct KnownSensor {
  ControlDelays delays;
  BlackLevel black_level;
};

// Looks up a sensor whose name occurs anywhere in the model text ("imx219",
// "/base/soc/i2c0mux/i2c@1/imx219@10"). nullopt for a sensor that is not in the table: its delays can be
// measured (delay_calibration.h). Source: libcamera's camera_sensor_properties.cpp and its tuning files.
std::optional<KnownSensor> known_sensor(std::string_view model);

}  // namespace hdrcam
