// Compares the exposure labels of frames with the true exposures that the simulated USB camera wrote into
// their pictures. Value type.
#pragma once

#include <string>

#include "hal/core/frame.h"

namespace hdrcam::hil {

struct LabelTally {
  // Frames of the beginning, of the stream and after a loss: a cycle.
  int beginning = 3;
  int frames = 0;
  int equal = 0, wrong = 0;            // of the proved and plausible labels
  int flagged_early = 0, flagged = 0;  // of the others: in the beginning; later
  int losses = 0;

  void add(const RawFrame& frame);
  std::string text() const;

 private:
  int since_loss_ = 0;
};

// Of all frames of the file.
LabelTally labels_of_recording(const std::string& path, int beginning = LabelTally().beginning);

}  // namespace hdrcam::hil
