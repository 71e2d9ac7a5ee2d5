// The meaning of the code of V4L2_CID_ANALOGUE_GAIN: the kernel passes a sensor's register value without its
// unit. The formulas are those of the data sheets, as libcamera lists them (camera_sensor_helper.cpp).
// Reentrant.
#pragma once

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

// The law of a sensor, by its entity name ("imx219 10-0010"). An unlisted sensor is assumed proportional,
// with gain 1 at the driver's `lowest_code`, which must be positive.
GainCodes gain_codes_of(std::string_view sensor, double lowest_code);

}  // namespace hdrcam
