// The clip.json of an image sequence (docs/recording.md): the facts of the camera and of each frame, and the
// image that holds its pixels. Every error names the file, the frame and the value. Reentrant.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/core/frame.h"
#include "hal/core/result.h"

namespace hdrcam {

struct ClipFrame {
  std::string file;  // relative to the folder of the clip.json
  FrameFacts facts;
};

struct Clip {
  CameraFacts camera;
  bool layout_is_named = false;  // otherwise the first image decides between RGB and mono
  std::vector<ClipFrame> frames;
};

constexpr std::size_t kFewestClipFrames = 2;  // that clip_from_json takes: one alone has no cycle

// path: of the clip.json, for the messages. Slots that no frame states are found from the exposures. Errors:
// Invalid (no JSON, with line and byte; a key that is missing or wrong), BadExposure, TooShort (below two
// frames).
Result<Clip> clip_from_json(std::string text, const std::string& path);

// Facts with their default value, and slots that follow from the exposures, are left out.
std::string clip_to_json(const Clip& clip);

}  // namespace hdrcam
