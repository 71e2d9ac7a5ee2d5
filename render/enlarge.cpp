#include "render/enlarge.h"

namespace hdrcam {

AxisTap reduced_tap(int at, int step, int size) {
  return tap_at((static_cast<float>(at) + 0.5f) / static_cast<float>(step) - 0.5f, size);
}

void enlarge(const Image<float>& in, int step, int rows, int cols, Image<float>& out, WorkerPool& pool) {
  out.reshape(in.channels(), rows, cols);
  if (step == 1) {
    out.copy_from(in);
    return;
  }
  pool.for_rows(rows, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      const AxisTap tap_y = reduced_tap(y, step, in.rows());
      for (int x = 0; x < cols; ++x) {
        const BetweenPixels place(tap_y, reduced_tap(x, step, in.cols()));
        for (int c = 0; c < in.channels(); ++c) out.at(c, y, x) = place.of(in, c);
      }
    }
  });
}

}  // namespace hdrcam
