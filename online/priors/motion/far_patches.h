// Patches that were found far from where they were expected (FlowKernels::search_far): which of them are
// believed, and what they tell the search back. One patch alone finds what looks like it, in a repeating
// texture above all; neighbours that found the same motion are an object. Reentrant.
#pragma once

#include "hal/core/image.h"
#include "online/priors/motion/flow_kernels.h"

namespace hdrcam {

// far: the vectors found, [dx dy, patch rows, patch cols], kNowhere elsewhere. kept: becomes those of them
// that enough neighbours agree with; returns how many they are.
int keep_agreeing(const Image<float>& far, Image<float>& kept);

// What was found far becomes the patch's answer, and, where it leads, a guess of the patches of the search
// back: others_back [dx dy, patch rows, patch cols], kNowhere elsewhere.
void take_far(const Image<float>& far, const PatchSearch& search, Image<float>& others_back);

}  // namespace hdrcam
