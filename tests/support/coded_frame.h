// Frames whose codes a test states, pixel by pixel.
#pragma once

#include "capture/exposed_frame.h"

namespace hdrcam::test {

// code(channel, row, column): 0..255; asked channel by channel and row by row.
template <class Code>
ExposedFrame coded_frame(int rows, int cols, Code&& code) {
  ExposedFrame frame;
  frame.codes.reshape(3, rows, cols);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < cols; ++x) frame.codes.at(c, y, x) = code(c, y, x);
  return frame;
}

}  // namespace hdrcam::test
