// Finds the exposure schedule from the exposures themselves: the shortest cycle that repeats. Exposures are
// products of time and gains (FrameFacts::exposure()). Reentrant.
#pragma once

#include <span>
#include <vector>

#include "hal/core/frame.h"

namespace hdrcam {

struct ExposureCycle {
  int period = 0;                 // slots in a cycle, 0 where nothing repeats
  std::vector<double> exposures;  // [period] geometric mean of each slot; slot 0 is that of the first frame
  bool recorded = false;          // the frames state their slots; slot 0 is the schedule's
};

constexpr double kSlotToleranceEv = 0.3;  // how far an exposure may be from the mean of its slot

// Where frames state their slots (FrameFacts::slot) and the exposures of each slot agree, those slots are the
// cycle; frames without a slot, as before the first control acted, are ignored. Otherwise the shortest
// period, at most half the range of sequence numbers, in which every exposure is within the tolerance of its
// slot's (logarithmic) mean and every slot occurs. The slot of a frame is its sequence number, counted from
// that of the first frame, modulo the period; so a dropped frame does not shift the slots. Exposures that are
// not positive and finite are ignored.
ExposureCycle find_exposure_cycle(std::span<const FrameFacts> frames, double tolerance_ev = kSlotToleranceEv);

// A frame's slot: its stated one, or that in a cycle that starts with the frame `first`; -1 for none.
int slot_of(const ExposureCycle& cycle, const FrameFacts& first, const FrameFacts& frame);

}  // namespace hdrcam
