// What a run gives up to hold its deadline, rung by rung: previews, steps of the field's fit, the field where
// it only fills, all later frames but one, the flow's quality to medium and to fast, that over clipped parts
// to coarse, the denser tiles of shrinkage, the look-ahead, the model of motion blur, the flow's quality to
// coarse, shrinkage, and at last emitted frames; never capture, never the recording: in the order of what a
// millisecond costs of the picture (docs/decisions/deadline.md). Rung 0 is what was asked for; each rung
// gives up one thing more than the one before. Plain values; reentrant.
#pragma once

#include <string>
#include <vector>

#include "online/frame_budget.h"

namespace hdrcam {

struct Rung {
  std::string name;  // what it gives up beyond the rung before: "flow fast"
  FrameBudget budget;
  bool previews = true;
  int emitted = 1, of = 1;  // HDR frames, of so many frames

  bool emits_all() const { return emitted == of; }
};

// None: the run has no field. Fills: it fills what no frame saw, and may rest. Seen: it is shown itself, and
// takes at least one step per frame.
enum class FieldUse { None, Fills, Seen };
enum class PreviewUse { None, Some };

std::vector<Rung> budget_ladder(const FrameBudget& asked, FieldUse field, PreviewUse previews);

}  // namespace hdrcam
