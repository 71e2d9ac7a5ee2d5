// The motion of what a frame clips, on raw pointers, a row of pixels at a time: one table of functions per
// instruction set, picked at start by clipped_motion_kernels(). Places between pixels are rounded to 1/32.
// Reentrant. Declarations only: the kernels' file may include nothing with inline code (CMakeLists.txt).
#pragma once

namespace hdrcam {

// Row y of pictures of [rows, cols], of which some are read elsewhere, too. Motions are [dx dy, rows, cols].
struct RowOfPictures {
  int rows, cols, y;
};

// The last motion goes on at constant velocity. What is clipped in one frame after the other has nobody who
// measures it, and a motion that was wrong once would stay; so it gives way, more with each such frame, to
// what the search spreads over it from its surroundings.
struct ContinuedRow {
  RowOfPictures at;
  const float* clipped;   // [cols] share of the pixels around each
  const float* last;      // the last motion, at the pixels that the new one leads to
  const float* measured;  // [rows, cols] 0..1: how much of that was measured, and how lately
  float ratio;            // of this motion's time to the last one's
  float *u, *v;           // [cols] this motion; becomes the last one where that goes on
  float* measured_now;    // [cols]
};

// A pixel x of a frame in between, with motion u to the state, is at x + u in the state and at x - u (1 - r)
// / r in the frame after, where r is its share of the time between them. Both flows are read there (a fixed
// point, three iterations) and averaged, at constant velocity, where the frame is clipped and the one after
// is not.
struct BridgedRow {
  RowOfPictures at;
  const float* clipped;                          // [cols] share of the pixels around each, in the frame
  const float* clipped_after;                    // [rows, cols] the same in the frame after
  const float *after_to_state, *state_to_after;  // motions
  float share;                                   // r
  float *u, *v;                                  // [cols] motion to the state
  float* measured;                               // [cols] 0..1: becomes 1 where the motion is taken from here
};

// The same from the state, at its own pixels.
struct BridgedAheadRow {
  RowOfPictures at;
  const float* clipped;  // [cols] in the frame in between, where the state's pixels move to
  const float* clipped_after;
  const float* state_to_after;
  float share;
  float *u, *v;  // [cols] motion from the state to the frame in between
};

struct ClippedMotionKernels {
  void (*go_on)(const ContinuedRow&);
  void (*bridge)(const BridgedRow&);
  void (*bridge_ahead)(const BridgedAheadRow&);
};

const ClippedMotionKernels& clipped_motion_kernels();

}  // namespace hdrcam
