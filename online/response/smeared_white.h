// How much of what the longer of two exposures clips is left below white: compression mixes the colour of
// clipped pixels with their neighbours', and so do a camera's demosaicing and noise reduction. Codes just
// below white then are clipped light more often than not, and what histograms match them with is brighter
// than what the camera measures there. Value type, reentrant.
#pragma once

#include <cstddef>

#include "online/response/sparse_channel.h"

namespace hdrcam {

class SmearedWhite {
 public:
  // Of one channel of both exposures, the same lines. Counts pixels that the shorter one shows to be far
  // brighter than white, and their neighbours, too: motion between the frames may move those. Nothing where
  // hardly a pixel is white, or nearly all are.
  void add(const SparseChannel& shorter, const SparseChannel& longer);

  // Of the pixels that are white beyond doubt, those whose code is not; 0 where too few were seen.
  double share() const;

 private:
  std::size_t white_ = 0, smeared_ = 0;  // pixels
};

}  // namespace hdrcam
