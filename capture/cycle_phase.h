// Which exposure of its cycle each frame of a clip had, found from the pictures alone, for footage that does
// not say it: the phase of the cycle, and where frames are missing. What is known of each step is the ratio
// of two neighbouring pictures (photometry.h). Under an unknown response a ratio is stretched by one factor
// for the whole clip, so that factor is found with the phase. The most probable walk through the cycle is a
// shortest path (Viterbi) over its slots; a step that leaves slots out is a loss and costs more, but where
// the frame's time says that something is missing. Reentrant.
#pragma once

#include <span>
#include <vector>

#include "capture/exposure.h"
#include "capture/photometry.h"

namespace hdrcam {

enum class StepKind {
  Measured,  // by what is visible in both pictures
  Rough,     // the steps of a cycle may leave nothing in common: how much brighter one is as a whole
};

// From a frame to a later one.
struct CycleStep {
  StepKind kind = StepKind::Rough;
  double log_ratio = 0;  // ln of the later exposure over the earlier one
  int missing = 0;       // frames in between, by the times of the two
};

// What the two pictures say. The scratch space of the photometer is used.
CycleStep step_between(Photometer& photometer, const PhotometricSignature& earlier,
                       const PhotometricSignature& later);
// The same where no ratio can be taken of them.
CycleStep rough_step(const PhotometricSignature& earlier, const PhotometricSignature& later);

struct CycleWalk {
  std::vector<int> slots;        // of each frame
  std::vector<int> lost_before;  // frames missing before each, 0.. slots-1 and those that times tell
  // Whether another phase explains the pictures about as well, as of two frames of a cycle in even steps.
  bool ambiguous = false;
  double stretch = 1;        // of the pictures' ratios against the true ones
  double mean_residual = 0;  // mean cost of a step, squared deviations in expected errors; below 1 is usual
  int measured = 0;          // steps of that kind
};

// steps: one less than frames. Errors: BadExposure where the pictures do not alternate as the cycle does, or
// in another order; Invalid for a cycle that is empty.
Result<CycleWalk> find_walk(std::span<const CycleStep> steps, std::span<const Exposure> cycle);

// How many frames look as the one before them, though each step of the cycle changes the exposure, and no
// time tells of a loss between them: copies, as programs make them that raise a frame rate. 0 for a cycle
// with a step that pictures need not show.
int count_copies(std::span<const CycleStep> steps, std::span<const Exposure> cycle);

// Steps over one, two and more frames: [lag - 1][frame], from that frame to the one `lag` later.
using StepsByLag = std::vector<std::vector<CycleStep>>;

// The cycle itself, where nobody knows it: 1 to 4 exposures whose ratios are those of the pictures under the
// mean response of real cameras, their geometric mean 10 ms. Relative: the unknown response may stretch all
// ratios alike. Errors: BadExposure where the pictures show no cycle.
Result<std::vector<Exposure>> estimate_cycle(const StepsByLag& steps);

}  // namespace hdrcam
