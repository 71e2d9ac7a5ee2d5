// A scene that the state knows well, and a camera with hardly any noise that films it: for tests of what is
// learned from comparing frames with the state. Reentrant.
#pragma once

#include "online/state/exposure_tables.h"
#include "online/state/radiance_state.h"

namespace hdrcam::test {

// radiance(channel, row, column)
template <class Radiance>
RadianceState known_scene(int rows, int cols, Radiance&& radiance) {
  RadianceState state{Image<float>(3, rows, cols), Image<float>(3, rows, cols), Image<float>(1, rows, cols)};
  state.variance.fill(1e-8f);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < cols; ++x) state.radiance.at(c, y, x) = radiance(c, y, x);
  return state;
}

constexpr float kQuietWell = 1e6f;  // electrons

// Of the reference exposure.
inline const ExposureTables& quiet_tables() {
  NoiseModel quiet;
  quiet.full_well = kQuietWell, quiet.code_noise = 0.1f;
  static const ExposureTables kTables(Response::gamma(2.2f), quiet, 1);
  return kTables;
}

}  // namespace hdrcam::test
