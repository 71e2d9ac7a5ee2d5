// A small stream for the fit: a textured wall, a bright square that may move, a cycle of exposures. The truth
// is known, so that the state can be exact, noisy or missing. Deterministic.
#pragma once

#include <cmath>

#include "online/scene/field_snapshot.h"
#include "online/scene/hash_grid/field/random.h"
#include "online/scene/hash_grid/fit/field_fit.h"

namespace hdrcam {

struct FitStream {
  int rows = 32, cols = 48;
  float speed_px = 1.5f;
  std::vector<float> exposures = {0.25f, 1, 4};
  Response response = Response::gamma(2.2f);
  Image<float> codes, radiance, variance;
  FlowField to_previous, from_previous;

  static constexpr int kSquare = 12;

  bool on_square(int i, int y, int x) const {
    const float left = 4 + speed_px * static_cast<float>(i % 20);
    return static_cast<float>(x) >= left && static_cast<float>(x) < left + kSquare && y >= 8 &&
           y < 8 + kSquare;
  }
  float truth(int i, int c, int y, int x) const {
    if (on_square(i, y, x)) return 1.5f + 0.2f * static_cast<float>(c);
    return 0.2f + 0.15f * std::sin(0.9f * static_cast<float>(x) + static_cast<float>(c)) *
                      std::cos(0.7f * static_cast<float>(y));
  }

  // The frame with a state of standard deviation `sigma` in log radiance; pixels clipped in this frame are
  // unseen if `forgetful`.
  FieldObservation frame(int i, float sigma = 0.05f, bool forgetful = false) {
    codes.reshape(3, rows, cols), radiance.reshape(3, rows, cols), variance.reshape(3, rows, cols);
    const float exposure = exposures[static_cast<std::size_t>(i) % exposures.size()];
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < rows; ++y)
        for (int x = 0; x < cols; ++x) {
          const float light = truth(i, c, y, x);
          codes.at(c, y, x) = std::round(255 * std::min(1.f, std::pow(light * exposure, 1 / 2.2f)));
          const bool lost = forgetful && light * exposure >= 1;
          radiance.at(c, y, x) = lost ? 1 / exposure : light;
          variance.at(c, y, x) = lost ? kUnseenVariance : sigma * sigma * light * light;
        }
    for (FlowField* flow : {&to_previous, &from_previous}) {
      flow->vectors.reshape(2, rows, cols), flow->confidence.reshape(1, rows, cols);
      flow->vectors.fill(0), flow->confidence.fill(1);
    }
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < cols; ++x) {
        if (on_square(i, y, x)) to_previous.vectors.at(0, y, x) = -speed_px;
        if (i > 0 && on_square(i - 1, y, x)) from_previous.vectors.at(0, y, x) = speed_px;
      }
    FieldObservation seen;
    seen.index = i;
    seen.time_s = i / 30.0;
    seen.exposure = exposure;
    seen.codes = &codes, seen.radiance = &radiance, seen.variance = &variance;
    if (i > 0) seen.to_previous = &to_previous, seen.from_previous = &from_previous;
    return seen;
  }

  static FieldOptions small_options() {
    FieldOptions options;
    options.shape.static_grid = {4, 10, 1, 4, 32, 0.75f, 0.25f};
    options.shape.dynamic_grid = {2, 9, 8, 4, 24, 0.75f, 0.25f};
    options.shape.hidden = 16;
    options.window.frames = 4;
    return options;
  }
  static FitBudget small_budget() { return {1, 64, 4, 4}; }

  // The view of a fit's own camera, one pixel for step x step.
  static SceneView view(const FieldFit& fit, const RigidTransform& T_world_camera, double time_s, int step) {
    const WindowFrustum& frustum = fit.field().window.frustum();
    return reduced({T_world_camera, time_s, 0, frustum.camera, frustum.rows, frustum.cols}, step);
  }
};

}  // namespace hdrcam
