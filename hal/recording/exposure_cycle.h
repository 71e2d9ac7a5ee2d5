// Finds the exposure schedule from the exposures themselves: the shortest cycle that repeats. Exposures are
// products of time and gains (FrameFacts::exposure()). Reentrant; a search is thread-bound.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "hal/core/frame.h"

namespace hdrcam {

struct ExposureCycle {
  int period = 0;                 // slots in a cycle, 0 where nothing repeats
  std::vector<double> exposures;  // [period] geometric mean of each slot; slot 0 is that of the first frame
  bool recorded = false;          // the frames state their slots; slot 0 is the schedule's
};

// Where frames state their slots (FrameFacts::slot) and the exposures of each slot agree, those slots are the
// cycle; frames without a slot, as before the first control acted, are ignored. Otherwise the shortest
// period, at most half the range of sequence numbers, in which every exposure is within .3 stops of its
// slot's (logarithmic) mean and every slot occurs. The slot of a frame is its sequence number, counted from
// that of the first frame, modulo the period; so a dropped frame does not shift the slots. Exposures that are
// not positive and finite are ignored.
ExposureCycle find_exposure_cycle(std::span<const FrameFacts> frames);

// The same, of frames that come one by one: it keeps none of them, however many there are.
class ExposureCycleSearch {
 public:
  void add(const FrameFacts& frame);
  // Of the frames so far.
  ExposureCycle cycle() const;

 private:
  static constexpr std::size_t kLongestPeriod = 64;  // no schedule is longer; bounds the search

  // The exposures of a slot, log2.
  struct SlotExposures {
    double sum_ev = 0, count = 0;
    double least_ev = std::numeric_limits<double>::infinity(), most_ev = -least_ev;

    void add(double ev);
    double mean_ev() const { return sum_ev / count; }
    bool agree() const;
  };
  static constexpr std::size_t first_slot(std::size_t period) { return period * (period - 1) / 2; }
  static ExposureCycle cycle_of(std::span<const SlotExposures> slots);

  std::uint64_t frames_ = 0;
  std::uint64_t first_ = 0, range_ = 0;  // of the sequence numbers
  bool runs_backward_ = false;           // the numbers, which then tell no slots
  int last_stated_ = -1;                 // the largest slot that a frame states
  std::vector<SlotExposures> stated_ = std::vector<SlotExposures>(kLongestPeriod);
  // Of each period 1, 2, .. its slots, from first_slot(period) on.
  std::vector<SlotExposures> counted_ = std::vector<SlotExposures>(first_slot(kLongestPeriod + 1));
};

// A frame's slot: its stated one, or that in a cycle that starts with the frame `first`; -1 for none.
int slot_of(const ExposureCycle& cycle, const FrameFacts& first, const FrameFacts& frame);

}  // namespace hdrcam
