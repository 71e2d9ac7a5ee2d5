// Patches that were found far from where they were expected (FlowKernels::search_far): which of them are
// believed, and what they tell the search back. One patch alone finds what looks like it, in a repeating
// texture above all; neighbours that found the same motion are an object.
// Reentrant.
#pragma once

#include "hal/core/image.h"
#include "online/priors/motion/flow_kernels.h"

namespace hdrcam {

// far: the vectors found, [dx dy, patch rows, patch cols], kNowhere elsewhere. Those that too few neighbours
// agree with become kNowhere; returns how many stay.
int keep_agreeing(const Image<float>& far, Image<float>& kept);

// What was found far becomes the patch's answer, and a guess of the patches back where it leads: others
// [dx dy, patch rows, patch cols], kNowhere elsewhere.
void take_far(const Image<float>& far, const PatchSearch& search, Image<float>& others_back);

}  // namespace hdrcam
