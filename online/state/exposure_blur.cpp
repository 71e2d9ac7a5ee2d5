#include "online/state/exposure_blur.h"

#include <atomic>

#include "online/state/exposure_blur_kernels.h"

namespace hdrcam {

bool exposure_blurs(const Image<float>& flow, float fraction, WorkerPool& pool) {
  std::atomic<bool> found = false;
  pool.for_rows(flow.rows(), [&](int y0, int y1) {
    if (found.load(std::memory_order_relaxed)) return;
    const int pixels = (y1 - y0) * flow.cols();
    if (exposure_blur_kernels().blurs(flow.row(0, y0), flow.row(1, y0), fraction, pixels)) found = true;
  });
  return found;
}

void blur_difference(const Image<float>& radiance, const Image<float>& flow, float fraction,
                     Image<float>& difference, WorkerPool& pool) {
  const int rows = radiance.rows(), cols = radiance.cols();
  HDRCAM_CHECK(radiance.channels() <= kBlurChannels);
  difference.reshape_like(radiance);
  if (rows < 2 || cols < 2) {
    difference.fill(0);
    return;
  }
  pool.for_rows(rows, [&](int y0, int y1) {
    exposure_blur_kernels().blur({radiance.plane(0), flow.plane(0), flow.plane(1), fraction,
                                  difference.plane(0), radiance.channels(), rows, cols, y0, y1});
  });
}

}  // namespace hdrcam
