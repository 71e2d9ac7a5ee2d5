// Whether pictures contradict the order in which they are said to have their exposures. A hand before the
// lens, a black frame, a lamp: each makes a step or two that go against the exposures. A wrong order makes
// the same step of the cycle go against them in nearly every round. Value type, no allocation.
#pragma once

#include "capture/cycle_phase.h"
#include "hal/core/inline_list.h"

namespace hdrcam {

class OrderCheck {
 public:
  // least: contradictions of one step of the cycle below which nothing is objected to.
  explicit OrderCheck(int least) : least_(least) {}

  // A step between neighbours whose exposures, ln, are said to be these. Returns whether the pictures
  // contradict it.
  bool add(double from, double to, const CycleStep& step);
  // Whether they contradict some step of the cycle more often than not.
  bool objects() const;

 private:
  struct Transition {
    double from = 0, to = 0;
    int steps = 0, against = 0;
  };
  static constexpr std::size_t kMost = 16;  // of a cycle of four, with losses; others are not counted

  int least_;
  InlineList<Transition, kMost> transitions_;
};

}  // namespace hdrcam
