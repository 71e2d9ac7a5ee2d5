// Every step-th line of one channel of a frame: what statistics of its codes look at (sparse_lines.h).
// Value type, reentrant; the picture outlives it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "hal/core/image.h"
#include "online/response/neighbour_medians.h"

namespace hdrcam {

struct SparseChannel {
  const Image<float>& codes;
  int channel, step;

  std::size_t pixels() const {
    const int lines = (codes.rows() + step - 1) / step;
    return static_cast<std::size_t>(lines) * static_cast<std::size_t>(codes.cols());
  }
  template <class Is>
  std::ptrdiff_t count(Is is) const {
    std::ptrdiff_t found = 0;
    for (int y = 0; y < codes.rows(); y += step)
      found += std::count_if(codes.row(channel, y), codes.row(channel, y) + codes.cols(), is);
    return found;
  }
  std::vector<float> plain_codes() const {
    std::vector<float> plain;
    plain.reserve(pixels());
    for (int y = 0; y < codes.rows(); y += step)
      plain.insert(plain.end(), codes.row(channel, y), codes.row(channel, y) + codes.cols());
    return plain;
  }
  std::vector<float> median_codes() const { return neighbour_medians(codes, channel, step); }
};

}  // namespace hdrcam
