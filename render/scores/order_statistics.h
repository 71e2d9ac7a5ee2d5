// Order statistics as numpy defines them, so that a score here is the score of any script. Reentrant.
#pragma once

#include <vector>

namespace hdrcam {

// The value below which `percent` (0..100) of the samples lie, linear between the two nearest. Reorders the
// samples, of which there is at least one.
double percentile(std::vector<float>& samples, double percent);

// Of an even number of samples: the mean of the middle two.
inline double median(std::vector<float>& samples) { return percentile(samples, 50); }

}  // namespace hdrcam
