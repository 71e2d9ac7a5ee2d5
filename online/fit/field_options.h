// Every knob of the field, with unit, range and reason. Plain values; the presets are points on a measured
// front of quality against time (docs/decisions.md).
#pragma once

#include <cstdint>

#include "online/field/field.h"
#include "online/fit/adam.h"
#include "online/fit/objective.h"

namespace hdrcam {

struct FieldOptions {
  // size
  FieldShape shape;      // grids, hidden width, form of the blend
  WindowOptions window;  // frames and gates
  float margin = 1.25f;  // 1..2: width of window space over the picture; more lets the camera go further
  float near = 1;        // near plane in the poses' unit, > 0
  // work
  int steps_per_frame = 30;  // 0..1000: Adam steps after each frame
  int rays_per_step = 256;   // 32..4096: many small steps beat few large ones on a CPU
  int samples_per_ray = 8;   // 1..16 where the camera moves and depth can be seen
  int samples_without_parallax =
      2;                // 1..16 where depth cannot be observed: two layers are all that can matter
  int render_step = 2;  // 1..8: the field is rendered at every n-th pixel
  // where the rays go
  float newest_share = 0.5f;  // 0..1 of the rays in the newest frame, the rest over the window
  float uniform_share =
      0.5f;  // 0..1 of the rays anywhere, the rest where the state is blind or the fit is bad
  // optimisation
  LossWeights losses = default_loss_weights();
  AdamOptions adam;
  float table_rate = 1e-2f;     // 1e-4..1e-1
  float network_rate = 2e-3f;   // 1e-4..1e-2
  float response_rate = 3e-4f;  // 0..1e-2: slow, the response estimate is already good
  bool fits_response = false;   // refine the response with the photometric loss; never on linear data
  std::uint64_t seed = 1;

  static FieldOptions fast();
  static FieldOptions balanced() { return {}; }
  static FieldOptions best();
};

inline FieldOptions FieldOptions::fast() {
  FieldOptions options;
  options.shape.static_grid.log2_entries = 14;
  options.shape.dynamic_grid.log2_entries = 12;
  options.steps_per_frame = 10;
  options.samples_per_ray = 6;
  options.samples_without_parallax = 1;
  options.render_step = 4;
  return options;
}

inline FieldOptions FieldOptions::best() {
  FieldOptions options;
  options.steps_per_frame = 100;
  options.render_step = 1;
  return options;
}

}  // namespace hdrcam
