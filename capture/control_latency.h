// How long it takes at most until a frame shows the exposure that was asked for: requests wait in the
// camera's queue, and controls act some frames after they are written. History, prediction and proof are
// sized for it. Constants.
#pragma once

namespace hdrcam {

// The longest delay of a control, frames: sensors need 1..3; a driver with an internal queue adds its depth.
inline constexpr int kMaxDelay = 15;
// Of most sensors, where nobody states it.
inline constexpr int kUsualDelay = 3;
// The most queued capture requests (--buffers).
inline constexpr int kMostBuffers = 32;

}  // namespace hdrcam
