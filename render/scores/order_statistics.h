// Order statistics as numpy defines them, so that scores here equal those of numpy scripts. Reentrant.
#pragma once

#include <vector>

namespace hdrcam {

// The value below which `percent` (0..100) of the samples lie, linear between the two nearest. Reorders the
// samples; at least one is needed.
double percentile(std::vector<float>& samples, double percent);

// Of an even number of samples: the mean of the middle two.
inline double numpy_median(std::vector<float>& samples) { return percentile(samples, 50); }

}  // namespace hdrcam
