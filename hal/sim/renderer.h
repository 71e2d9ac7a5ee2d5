// Renders a scene as a sensor's pixels see it: the average radiance over the pixel's area and over its
// exposure. Four rays paint a pixel, sharp or blurred, so that the two differ by their blur alone; where the
// motion of its tile is longer than four pixels and crosses the pixel by more than three there are as many as
// the motion needs, and where several surfaces meet twice as many. Rays test only the objects that are
// visible in their tile of the picture. Thread-bound; owns its buffers, allocates nothing after the first
// frame of a size; the result does not depend on the number of threads.
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

// When the first row is exposed, in scene time. begin = end: a sharp picture of that instant.
struct ExposureSpan {
  double begin_s = 0, end_s = 0;
};

// Nothing is computed for one that is absent.
struct ShutterEffects {
  std::optional<MotionBlur> blur;
  std::optional<RollingShutter> rolling;
};

// The least number of rays per pixel.
enum class Sampling {
  Smooth,  // four
  Quick,   // one, through its centre: outlines are jagged
};

class Renderer {
 public:
  // The scene outlives the renderer, and so does the pool.
  Renderer(const Scene& scene, Lens lens, ShutterEffects shutter, int rows, int cols, WorkerPool& pool,
           Sampling sampling = Sampling::Smooth);

  const ShutterEffects& shutter() const { return shutter_; }
  // light: [rgb, rows, cols] mean radiance
  void render(ExposureSpan span, Image<float>& light);

 private:
  static constexpr int kTile = 16;  // pixels: the tile size of the decisions what is near and how blurred..
  static constexpr int kProbe = 4;  // ..from rays this far apart
  static constexpr int kMostViews = 256;  // instants at which the scene is posed for one frame
  static constexpr int kRays = 4;         // of a smooth pixel, at least
  // Objects that rays of a tile can meet.
  using Near = std::span<const std::uint8_t>;

  void pose_views(double begin_s, double end_s);
  const View& view_at(double time_s) const;
  double row_delay_s(int row) const { return shutter_.rolling ? shutter_.rolling->delay_s(row) : 0; }
  void find_near_objects();
  Near near(int tile_y, int tile_x) const;
  void measure_blur(ExposureSpan span);
  void spread_blur();
  void render_tile(ExposureSpan span, int tile_y, int tile_x, Image<float>& light) const;
  Hit cast(const View& view, int y, int x, Vec2 place, Near objects) const;
  Colour mean_radiance(ExposureSpan row, int y, int x, int along_motion, Near objects) const;
  Colour mean_of_many(ExposureSpan row, int y, int x, int samples, Near objects) const;

  const Scene& scene_;
  Lens lens_;
  ShutterEffects shutter_;
  int rows_, cols_;
  int tile_rows_, tile_cols_;
  WorkerPool& pool_;
  const Sampling sampling_;
  const PixelSamples samples_;
  std::vector<View> views_;  // at even steps from first_s_
  double first_s_ = 0, views_per_s_ = 0;
  int view_count_ = 0;
  std::vector<RayBox> reach_;             // of each object, over all views
  Image<std::uint8_t> near_;              // [tile rows, tile cols, objects] indices, the first..
  Image<std::uint8_t> near_count_;        // [1, tile rows, tile cols] ..so many
  Image<float> tile_blur_, spread_blur_;  // [1, tile rows, tile cols] pixels
};

}  // namespace hdrcam
