// Depth as the pictures of other views need it: smooth within a surface, so that it is not torn by the noise
// of its estimate, and with steps where the picture has edges. A median takes out single errors; then a
// recursive filter smooths along rows and columns and is stopped by differences of log luminance (domain
// transform, Gastal and Oliveira 2011, recursive form). Thread-bound; the answer does not depend on the
// number of threads.
#pragma once

#include "hal/core/image.h"
#include "hal/core/worker_pool.h"

namespace hdrcam {

class DepthEdges {
 public:
  explicit DepthEdges(WorkerPool& pool) : pool_(pool) {}

  // radiance: [rgb, rows, cols]; offset: differences of radiance below it are noise; inverse_depth: [1, rows,
  // cols] > 0, is replaced.
  void follow(const Image<float>& radiance, float offset, Image<float>& inverse_depth);

 private:
  void take_median(const Image<float>& in, Image<float>& out);
  void measure_gaps(const Image<float>& radiance, float offset);
  void smooth_rows(float sigma, Image<float>& depth);
  void smooth_cols(float sigma, Image<float>& depth);

  WorkerPool& pool_;
  Image<float> log_luminance_, calm_;
  Image<float> gap_;  // [x y, rows, cols] distance to the pixel before: 1 and what the edge adds
};

}  // namespace hdrcam
