// The exposure of a frame as EXIF states it (Exif 2.32, 4.6.5: ExposureTime, PhotographicSensitivity,
// FNumber). ISO 100 is gain 1. A frame's facts have no aperture of their own: digital_gain carries it, as 1 /
// N^2, the light of an f-number against that of f/1. Of a clip only the ratios of its frames count.
// Reentrant.
#pragma once

#include <optional>

#include "hal/core/frame.h"

namespace hdrcam {

struct ExifExposure {
  double time_s;
  std::optional<double> iso, f_number;  // none: not stated, and the gain stays as it is
};

// Which of the two a file states beside the time.
struct ExifFactors {
  bool iso = false, f_number = false;
};
inline ExifFactors factors_of(const ExifExposure& stated) {
  return {stated.iso.has_value(), stated.f_number.has_value()};
}

inline void take_exif_exposure(const ExifExposure& stated, FrameFacts& facts) {
  constexpr double kIsoOfUnitGain = 100;
  facts.exposure_source = ExposureSource::Embedded;
  facts.exposure_s = stated.time_s;
  if (stated.iso) facts.analogue_gain = *stated.iso / kIsoOfUnitGain;
  if (stated.f_number) facts.digital_gain = 1 / (*stated.f_number * *stated.f_number);
}

}  // namespace hdrcam
