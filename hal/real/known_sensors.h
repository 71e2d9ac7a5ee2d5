// What the kernel does not say of a sensor and its data sheet does. Reentrant.
//   the meaning of the code of V4L2_CID_ANALOGUE_GAIN, a register's value without its unit: the formulas are
//   those of the data sheets, as libcamera lists them (camera_sensor_helper.cpp)
//   whether its rows are exposed one after the other
// capture/sensor_table.h is another table, for any camera: control delays and black level.
#pragma once

#include <optional>
#include <string_view>

namespace hdrcam {

struct GainCodes {
  // Proportional: gain = code / scale. Reciprocal: gain = scale / (scale - code). Decibel: 20 log10 gain =
  // code * scale.
  enum class Law { Proportional, Reciprocal, Decibel } law = Law::Proportional;
  double scale = 16;

  double gain_of(double code) const;
  double code_of(double gain) const;
};

// The law of a sensor, by its entity name ("imx219 10-0010"). An unlisted one, and a camera that has no such
// name (""), is assumed proportional, with gain 1 at the driver's `lowest_code`; codes from 0 on define no
// factors then: nullopt.
std::optional<GainCodes> gain_codes_of(std::string_view sensor, double lowest_code);

enum class Shutter { Unknown, Rolling, Global };
// Of a sensor, by its entity name; Unknown for an unlisted one.
Shutter shutter_of(std::string_view sensor);

}  // namespace hdrcam
