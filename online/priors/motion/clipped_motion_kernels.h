// Motion that a frame does not show, of what it clips and of the step after it, on raw pointers, a row of
// pixels at a time: one table of functions per instruction set, picked at start by clipped_motion_kernels().
// Pictures are read at the nearest pixels. Reentrant. Declarations only: the kernels' file may include
// nothing with inline code (CMakeLists.txt).
#pragma once

namespace hdrcam {

// Row y of pictures of [rows, cols], of which some are read elsewhere, too. Motions are [dx dy, rows, cols].
struct RowOfPictures {
  int rows, cols, y;
};

// The motion goes on as predicted. What is clipped in one frame after the other has nobody who measures it,
// and a motion that was wrong once would stay; so it gives way, more with each such frame, to what the search
// spreads over it from its surroundings.
struct ContinuedRow {
  RowOfPictures at;
  const float* clipped;    // [cols] share of the pixels around each
  const float* predicted;  // [2, rows, cols] this motion, if it took as long as the last one, at the pixels
                           // that it leads to; null: there is none
  const float* measured;   // [rows, cols] 0..1: how much of the last motion was measured, and how lately
  float ratio;             // of this motion's time to the last one's
  float *u, *v;            // [cols] this motion; becomes the predicted one where that goes on
  float* measured_now;     // [cols]
};

// The path of the state's pixels over a clipped frame. With times as shares of that from the state to the
// frame after, r to the clipped frame, B from the frame before the state, and motions D to the frame after
// and L to the frame before: constant acceleration through all three is a = (D + L / B) / (1 + B); its bend
// at r, of which .6 count (errors of two flows are in it), is b = .6 r (1 - r) a; and the motion to the
// clipped frame is r D - b / (1 + |b|^2 / 4 px^2).
struct PathAhead {
  const float *after_to_state, *state_to_after;  // [2, rows, cols] motions
  const float* last;      // [2, rows, cols] motion to the frame before, or null: then speed is constant
  const float* measured;  // [rows, cols] 0..1: how much of that was measured, and how lately
  float share;            // r
  float before;           // B
};

// Sums over the pixels of a cell (landing.h) that are compared.
struct CheckedPathCell {
  float pixels = 0, path_u = 0, path_v = 0;  // all of them, and the path's motion to the state
  float told = 0;                            // those where the frame shows the motion and the path is known
  float off_u = 0, off_v = 0, off2 = 0;      // of these, by how much what it shows differs from the path
};

// Where a frame is not clipped, it shows its motion, and the path of BridgedRow tells it, too.
struct CheckedPathRow {
  RowOfPictures at;
  const float* clipped;        // [cols] share of the pixels around each, in the frame
  const float* clipped_after;  // [rows, cols] the same in the frame after
  PathAhead path;
  const float *u, *v;      // [cols] motion to the state, as the frame shows it
  CheckedPathCell* cells;  // [cells of the row] added to
};

// Pixels from the state to the frame after a clipped one: what moves farther has left the pixels at which its
// flows are read first, and is blurred beyond recognition in a long exposure.
constexpr float kFastOverClipped = 12;

// A pixel x of the clipped frame, with motion u to the state, is at x + u in the state and at x + u + D in
// the frame after, where D is the motion between these. Both flows are read there (a fixed point, two
// iterations) and averaged, where the frame is clipped and the one after is not. What moves fast is sought
// from where it lands, too, unless that is known to a pixel; where the flows agree that it is there, it
// counts, and it counts where the frame is not clipped, if that one's own flows, there and back, lead
// elsewhere.
struct BridgedRow {
  RowOfPictures at;
  const float* clipped;        // [cols] share of the pixels around each, in the frame
  const float* clipped_after;  // [rows, cols] the same in the frame after
  PathAhead path;
  const float *landed_u, *landed_v;  // [cells of the row] D of what lands in each of 8 pixels (landing.h)
  const float* from;  // [2, rows, cols] motion from the state to the frame, as the frame shows it
  float *u, *v;       // [cols] motion to the state
  float* measured;    // [cols] 0..1: becomes 1 where the motion is taken from here
  const float *off_u = nullptr, *off_v = nullptr;  // [cells of the row] added to the path's motion, or null
};

// The same from the state, at its own pixels, whose flow after_to_state confirms where it is fast.
struct BridgedAheadRow {
  RowOfPictures at;
  // [rows, cols] share of the pixels around each; of the frame in between it is read where constant velocity
  // takes the state's pixels
  const float *clipped, *clipped_after;
  PathAhead path;
  const float* to;             // [2, rows, cols] motion to the state
  float *u, *v;                // [cols] motion from the state to the frame in between
  const float* off = nullptr;  // [2, cells down, cells across] as added to the motion to the state, or null
};

// The motion of the next step, if that takes as long as this one: the change from the last motion to this one
// goes on, by half, where both were measured. A change of a pixel and more is rather an error of the flow.
struct PredictedRow {
  RowOfPictures at;
  const float *u, *v;            // [cols] this motion
  const float* measured;         // [cols] 0..1: how much of it was measured, and how lately
  const float* last;             // [2, rows, cols] the last motion, at the pixels that this one leads to
  const float* measured_before;  // [rows, cols] the same of the last motion
  float ratio;                   // of this motion's time to the last one's
  float *next_u, *next_v;        // [cols]
};

struct ClippedMotionKernels {
  void (*go_on)(const ContinuedRow&);
  void (*compare)(const CheckedPathRow&);
  void (*bridge)(const BridgedRow&);
  void (*bridge_ahead)(const BridgedAheadRow&);
  void (*predict)(const PredictedRow&);
};

const ClippedMotionKernels& clipped_motion_kernels();

}  // namespace hdrcam
