// Codes without most of their noise: of each pixel the median of itself and its eight neighbours. Noise
// widens the histogram of a dark frame: the brightest half of what is dark then has the codes of lucky
// pixels, and matches light that is octaves brighter. A mean would take the noise away, too, but not the same
// one before and after a response; a median is one of the codes, so whatever rising curve or exposure
// follows, it is the median of the light. Of white noise .18 of the variance is left. Reentrant.
#pragma once

#include <vector>

#include "hal/core/image.h"

namespace hdrcam {

// Of every step-th line of a channel, codes [channels, rows, cols]. A line has `cols` of them; at the border
// neighbours are repeated.
std::vector<float> neighbour_medians(const Image<float>& codes, int channel, int step);

}  // namespace hdrcam
