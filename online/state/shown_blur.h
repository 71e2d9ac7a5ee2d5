// Whether frames show the motion blur that their exposure times state. Stills that are played as a video, a
// flash or a wrong time show none; and of a stream whose exposures outlast their frames the times or the time
// stamps are wrong, so that nothing states the blur. New frames are compared with the carried state: how much
// of their difference is the state's blur along the motion, less what a blur across it explains as well. What
// makes textures weak otherwise (noise, compression, an error of the response) does so in all directions.
// Thread-bound; the result does not depend on the number of threads.
#pragma once

#include <vector>

#include "hal/core/worker_pool.h"
#include "online/state/state_comparison.h"

namespace hdrcam {

class ShownBlur {
 public:
  explicit ShownBlur(WorkerPool& pool) : pool_(pool) {}

  // The share of the motion since the frame before that blurs a frame by its facts; more than 1 where its
  // exposure outlasts it, or ends a frame after a short one before it. 0: unknown, or so long that it is that
  // of a still.
  static float stated(const ExposedFrame& frame);

  // Takes note of the exposure that a frame states. While exposures outlast their frames, blur counts only if
  // frames show it.
  void observe_exposure(const ExposedFrame& frame);
  // What counts of a stated share.
  float counted(float stated) const { return shown_ ? stated : 0; }

  // Learns from a frame, whose facts state this share, and the state of the frame before.
  void observe(const StateComparison& compared, float stated);
  // The comparisons so far do not hold any more, because the response became another one; what they decided
  // does not depend on it.
  void forget() { evidence_ = {}; }

  bool shown() const { return shown_; }

 private:
  // Sums over comparisons d = k_along b_along + k_across b_across, weighted.
  struct Evidence {
    double along2 = 0, both = 0, across2 = 0, by_along = 0, by_across = 0, count = 0;
  };
  struct Seen;
  static Evidence compare_line(const Seen& seen, int y);
  static void compare(const Seen& seen, int channel, int y, int x, Evidence& evidence);
  void decide();

  WorkerPool& pool_;
  std::vector<Evidence> lines_;  // of the current frame
  Evidence evidence_;
  long frames_ = 0, outlasting_ = 0;  // observed; of these, exposed for longer than a frame lasts
  int settling_ = 0;                  // frames until the state has followed what was decided
  bool doubted_ = false, shown_ = true;
};

}  // namespace hdrcam
