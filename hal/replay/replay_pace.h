// How fast a recording that plays a camera delivers its frames. Plain value.
#pragma once

namespace hdrcam {

enum class ReplayPace {
  AsRecorded,     // a frame comes no earlier after start() than it did after the first frame, but for long
                  // pauses, which are cut (replayed_camera.h)
  AsFastAsAsked,  // as soon as it is waited for
};

}  // namespace hdrcam
