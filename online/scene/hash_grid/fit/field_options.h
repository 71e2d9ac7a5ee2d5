// The options of a hash grid field that are fixed at its start, with unit, range and reason; those that may
// change from frame to frame are in ../../fit_budget.h. Plain values; online/knobs.h names them.
#pragma once

#include <cstdint>

#include "online/scene/hash_grid/field/field.h"
#include "online/scene/hash_grid/fit/adam.h"
#include "online/scene/hash_grid/fit/loss_table.h"

namespace hdrcam {

struct FieldOptions {
  // size
  int step_px = 1;   // 1, 2, 4 or 8: the field's pixels are blocks of so many pixels of the stream, squared
  FieldShape shape;  // grids, hidden width, form of the blend
  WindowOptions window;  // frames and gates
  float margin = 1.25f;  // 1..2: width of window space over the picture; larger allows more camera motion
  float near = 1;        // near plane in the poses' unit, > 0
  // where the rays go
  float newest_share = 0.5f;  // 0..1 of the rays in the newest frame, the rest over the window
  // 0..1 of the rays uniformly; the rest where the state is uncertain or the fit is bad.
  float uniform_share = 0.5f;
  // optimisation
  LossWeights losses = default_loss_weights();
  AdamOptions adam;
  float table_rate = 1e-2f;     // 1e-5..1
  float network_rate = 2e-3f;   // 1e-5..1
  float response_rate = 3e-4f;  // 0..1e-2: slow, the response estimate is already good
  bool fits_response = false;   // refine the response with the photometric loss; never on linear data
  std::uint64_t seed = 1;
};

}  // namespace hdrcam
