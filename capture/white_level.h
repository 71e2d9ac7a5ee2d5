// Where a camera's codes clip, which need not be at the largest: log profiles leave room above white, and
// some encoders round the colour of white down, which takes a few codes of red and blue. Whoever knows
// clipped light by the largest codes alone would take it for measured light. Thread-bound.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "hal/core/frame.h"
#include "hal/core/white_level.h"

namespace hdrcam {

class WhiteSearch {
 public:
  explicit WhiteSearch(const CameraFacts& camera)
      : bits_(camera.bits), is_judged_(!camera.linear && !is_bayer(camera.layout)) {}

  // Frames in order, with their exposures.
  void observe(const RawFrame& frame);
  // White is the brightest code that many pixels have in frames of two exposures, a stop or more apart: what
  // is not clipped is brighter in the longer one. The largest code in channels that clip there, and where
  // nothing shows white. Linear codes are not judged: raw stills state their white level.
  WhiteLevel found() const;

 private:
  static constexpr int kCodes = 256;

  // Codes of 255; one alike for mono.
  struct White {
    double mean = 0, share = 0;  // of the channels; of the pixels that are as bright or brighter
    std::array<double, 3> of_channel{};
  };
  struct Seen {
    double exposure_ev = 0;  // log2 of the exposure
    std::optional<White> white;
    std::array<double, kCodes> darker{};  // share of the pixels, by the mean code of the channels
    double code_at(double share) const;   // below which so many pixels are
  };
  static bool is_clipped_in(const Seen& bright, const Seen& other);

  const int bits_;
  const bool is_judged_;
  std::vector<Seen> seen_;  // one of each exposure, up to kMostExposures
};

}  // namespace hdrcam
