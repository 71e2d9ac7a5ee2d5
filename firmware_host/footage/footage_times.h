// When the frames of footage are, and which of them are missing between. Reentrant.
#pragma once

#include <optional>
#include <string>

#include "firmware_host/footage/footage_scan.h"

namespace hdrcam {

// Where the times of the frames come from.
enum class TimeOrigin {
  Files,  // a video's own times where they increase; others one after the other at the frame rate
  Exif,   // when each still was taken
};

struct FootageTimes {
  TimeOrigin origin = TimeOrigin::Files;
  std::optional<StillPause> pause;  // the first, as EXIF says
  std::string trouble;  // why the times in EXIF, or those of a video, are not taken, a clause; "": they are
};

// Gives the frames their times, the camera its frame rate and the steps of neighbouring frames what is
// missing there. rate_hz: as the user names it, or 0: as the files state it. Errors: Invalid for a rate that
// is named for videos with times of their own, and for videos of different rates.
Result<FootageTimes> take_times(FootageScan& seen, double rate_hz);

}  // namespace hdrcam
