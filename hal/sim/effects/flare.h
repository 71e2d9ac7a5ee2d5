// Veiling flare: a part of all light is scattered in the lens into a wide halo around its true place, out =
// (1 - s) in + s halo(in); the halo is three box filters, close to a Gaussian, at an eighth of the
// resolution. It preserves the total light: the border is repeated. Thread-bound, owns its buffers.
#pragma once

#include "hal/core/image.h"
#include "hal/core/worker_pool.h"

namespace hdrcam {

struct FlareSettings {
  float strength = 0.008f;  // share of the light that is scattered, 0..1
  float reach = 0.08f;      // radius of the box, as a share of the picture's width
};

class Flare {
 public:
  Flare(FlareSettings settings, int rows, int cols);
  // light: [rgb, rows, cols], in place
  void apply(Image<float>& light, WorkerPool& pool);

 private:
  static constexpr int kCell = 8;  // pixels per side of one sample of the halo
  void shrink(const Image<float>& light, int channel);
  void box_rows(int channel), box_columns(int channel);
  float halo_at(int channel, float y, float x) const;

  float strength_;
  int radius_;                // cells
  Image<float> halo_, line_;  // [rgb, cells, cells]
};

}  // namespace hdrcam
