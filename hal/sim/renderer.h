// Renders a scene as a sensor's pixels see it: the average radiance over the pixel's area and over its
// exposure. Work is spent where the picture asks for it: four rays a pixel on smooth surfaces at rest, twice
// as many on outlines, as many as the motion is long under motion blur. Thread-bound; owns its buffers,
// allocates nothing after the first frame of a size; the result does not depend on the number of threads.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "hal/core/image.h"
#include "hal/core/worker_pool.h"
#include "hal/sim/effects/motion_blur.h"
#include "hal/sim/effects/rolling_shutter.h"
#include "hal/sim/lens.h"
#include "hal/sim/pixel_samples.h"
#include "hal/sim/view.h"

namespace hdrcam {

// The time that the first row is exposed, in scene time. begin = end: the sharp instant.
struct ExposureSpan {
  double begin_s = 0, end_s = 0;
};

// Effects of the shutter; nothing is computed for one that is absent.
struct Shutter {
  std::optional<MotionBlur> blur;
  std::optional<RollingShutter> rolling;
};

class Renderer {
 public:
  // The scene outlives the renderer, and so does the pool.
  Renderer(const Scene& scene, Lens lens, Shutter shutter, int rows, int cols, WorkerPool& pool);

  // light: [rgb, rows, cols] mean radiance
  void render(ExposureSpan span, Image<float>& light);

 private:
  static constexpr int kTile = 16;        // pixels: the grain of the decision how much blur there is..
  static constexpr int kProbe = 4;        // ..from rays that are so far apart
  static constexpr int kMostViews = 256;  // instants at which the scene is posed for one frame
  static constexpr int kLeastSamples = 4;

  void pose_views(double begin_s, double end_s);
  const View& view_at(double time_s) const;
  double row_delay_s(int row) const { return shutter_.rolling ? shutter_.rolling->delay_s(row) : 0; }
  void measure_blur(ExposureSpan span);
  void spread_blur();
  Colour mean_radiance(ExposureSpan span, int y, int x, int samples) const;

  const Scene& scene_;
  Lens lens_;
  Shutter shutter_;
  int rows_, cols_;
  WorkerPool& pool_;
  const PixelSamples samples_;
  std::vector<View> views_;  // at even steps from first_s_
  double first_s_ = 0, step_s_ = 0;
  int view_count_ = 0;
  Image<float> tile_blur_, spread_blur_;  // [1, tiles, tiles] pixels
};

}  // namespace hdrcam
