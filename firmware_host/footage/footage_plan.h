// What footage becomes as a recording, before anything is written: it is read once, and each frame gets the
// exposure that its file states, or its place in the cycle that the user names or the pictures show. Then it
// is read again as if it were a recording, with those facts. Thread-bound; the storage outlives what is
// opened.
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "capture/cycle_phase.h"
#include "firmware_host/footage/footage_times.h"
#include "hal/footage/footage.h"
#include "hal/recording/recording.h"

namespace hdrcam {

inline constexpr const char* kAutoShutter = "auto";

// In which order the files are read.
enum class FootageOrder {
  Given,
  // Of a folder: that of their numbers, but from the first on by EXIF where a camera's counter began anew.
  Numbers,
};

struct FootageRequest {
  std::vector<std::string> files;
  FootageOrder order = FootageOrder::Given;
  std::string shutter, gain;  // "1ms,4ms,16ms"; "auto"; "" where the files state their exposures
  // Of stills; 0: as EXIF says when they were taken, or 30. And of a video without times, or whose times do
  // not increase; 0: the rate that it states.
  double framerate_hz = 0;
};

enum class ExposureOrigin {
  Stated,     // by each file
  Cycle,      // named by the user, its phase found in the pictures
  Estimated,  // from the pictures: relative
};

struct FootagePlan {
  std::vector<std::string> files;  // in the order in which they are read
  bool goes_round = false;         // their numbers begin anew on the way
  CameraFacts camera;
  std::string about;                       // "h264, yuv420p"
  std::string primaries;                   // other than BT.709's, "bt2020"; "": none are stated
  std::vector<OrientedFile> orientations;  // the first file of each; applied
  bool oblique = false;  // a file states a turn that is no multiple of 90 degrees, which is not applied
  FootageTimes times;
  ExposureOrigin origin = ExposureOrigin::Stated;
  std::vector<Exposure> cycle;  // empty where files state exposures that do not repeat
  CycleWalk walk;               // of a cycle; where files state their exposures only what is missing
  int copies = 0;               // frames that look as the one before them, against the cycle
  std::vector<FrameFacts> facts;
  std::vector<Instant> as_read;       // when each frame is, by the reader of the footage
  std::vector<FootageLosses> losses;  // of files that are not whole
};

// stop: ends the reading with Interrupted. Errors: those of open_footage and its frames; TooShort below two
// frames; BadExposure where no exposure is known, or the pictures do not alternate as the cycle; Invalid for
// a frame rate that no recording can have, and for one that is named for videos with times of their own.
Result<FootagePlan> plan_footage(Storage& storage, const FootageRequest& request,
                                 const std::atomic<bool>& stop);

// The plan of a clip that says its exposures itself. facts: of its frames, in order.
FootagePlan plan_of_clip(CameraFacts camera, std::vector<FrameFacts> facts);

// The frames of the plan. Errors: those of open_footage; of a frame Corrupt or Truncated where the footage is
// not read as it was for the plan.
Result<std::unique_ptr<RecordingReader>> open_planned(Storage& storage, const FootageRequest& request,
                                                      const FootagePlan& plan);

}  // namespace hdrcam
