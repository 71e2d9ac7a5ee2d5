// The exposure schedule as far as the exposures themselves tell: the shortest cycle that repeats. Exposures
// are products of time and gains (FrameFacts::exposure()). Reentrant.
#pragma once

#include <span>
#include <vector>

#include "hal/core/frame.h"

namespace hdrcam {

struct ExposureCycle {
  int period = 0;                 // slots in a cycle, 0 where nothing repeats
  std::vector<double> exposures;  // [period] geometric mean of each slot; slot 0 is that of the first frame
  bool recorded = false;          // the frames say their slots themselves; slot 0 is the schedule's
};

constexpr double kSlotToleranceEv = 0.3;  // how far an exposure may be from the mean of its slot

// Where frames say their slots (FrameFacts::slot) and each slot's exposures agree, that is the cycle: frames
// without a slot, as before the first control acted, are no part of it. Else the shortest period, at most
// half the range of sequence numbers, in which every exposure stays within the tolerance of its slot's
// (logarithmic) mean and every slot was seen. The slot of a frame is its sequence number, counted from that
// of the first frame, modulo the period; so a dropped frame does not shift the slots. Exposures that are not
// positive and finite take no part.
ExposureCycle find_exposure_cycle(std::span<const FrameFacts> frames, double tolerance_ev = kSlotToleranceEv);

// The slot of a frame: its own, or in a cycle that starts with the frame `first`; -1 where it has none.
int slot_of(const ExposureCycle& cycle, const FrameFacts& first, const FrameFacts& frame);

}  // namespace hdrcam
