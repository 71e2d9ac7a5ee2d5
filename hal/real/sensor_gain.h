// What the code of V4L2_CID_ANALOGUE_GAIN means: the kernel passes a sensor's register value and says nothing
// about it. The formulas are those of the data sheets, as libcamera lists them (camera_sensor_helper.cpp).
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

// Of a sensor by its entity name ("imx219 10-0010"). A sensor that is not listed is taken as proportional,
// with gain 1 at its lowest code, which is then known to be positive; `lowest_code` is of the driver.
GainCodes gain_codes_of(std::string_view sensor, double lowest_code);

}  // namespace hdrcam
