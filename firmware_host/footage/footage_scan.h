// One look at all frames of footage: their facts, and how neighbouring pictures compare. Reentrant.
#pragma once

#include <atomic>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "capture/cycle_phase.h"
#include "hal/footage/footage.h"

namespace hdrcam {

// The first files that do and do not state a factor of the exposure; "": none.
struct StatedFactor {
  std::string by, not_by;

  void note(bool stated, const std::string& path) {
    if (std::string& first = stated ? by : not_by; first.empty()) first = path;
  }
};

struct FootageScan {
  CameraFacts camera;
  std::string about, primaries;  // as the reader has them, with what follows
  std::vector<OrientedFile> orientations;
  bool oblique = false;
  std::vector<FrameFacts> facts;
  std::vector<std::optional<ExifTime>> taken;
  bool stills = false;              // at least one
  std::vector<std::string> paths;   // of the files with frames
  std::vector<std::size_t> begins;  // the first frame of each
  std::string timed;                // the first video that says when its frames are; "": none
  StepsByLag steps;
  StatedFactor iso, f_number;
  std::string low_codes;  // what LowCodes suspects
  std::string silent;     // the first file with a frame whose exposure it does not state; "": none
  std::vector<FootageLosses> losses;
};

// stop: ends it with Interrupted. Errors: those of the frames; TooShort below two.
Result<FootageScan> scan_footage(FootageReader& footage, const std::atomic<bool>& stop);

}  // namespace hdrcam
