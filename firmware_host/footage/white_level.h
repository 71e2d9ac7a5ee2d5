// Whether pictures clip below the largest code: log profiles leave room above white, and some encoders round
// the colour of white down, which takes a few codes of red and blue. The pipeline knows clipped light by the
// largest codes alone and would take it for measured light. Thread-bound.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "hal/core/frame.h"

namespace hdrcam {

class WhiteLevel {
 public:
  explicit WhiteLevel(const CameraFacts& camera) : camera_(camera) {}

  // Frames in order, with their exposures.
  void observe(const RawFrame& frame);
  // A sentence without a full stop, or "". White is the brightest code that many pixels have in frames of two
  // exposures, a stop or more apart: what is not clipped is brighter in the longer one. Linear codes are not
  // judged: raw stills state their white level.
  std::string warning() const;

 private:
  // What the brightest pixels of a frame have in common, codes of 255.
  struct BrightestCodes {
    double exposure_ev = 0;              // log2 of the exposure
    double mean = 0;                     // of the channels
    std::array<double, 3> of_channel{};  // of one alike for mono
  };

  const CameraFacts camera_;
  std::vector<BrightestCodes> brightest_;  // one of each exposure, up to kMostExposures
};

}  // namespace hdrcam
