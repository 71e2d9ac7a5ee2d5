// How long the work on a frame took: what the pipeline measures and the governor decides by, so that neither
// needs to know the other. Plain value.
#pragma once

namespace hdrcam {

// The time of the work on one frame, or of one call that did several frames at once (the first ones).
struct FrameWork {
  int frames = 0;        // 0: the call only stored its frame
  double total_ms = 0;   // all of it
  double steady_ms = 0;  // the part of it that is the same on every rung, for the same frame
};

}  // namespace hdrcam
