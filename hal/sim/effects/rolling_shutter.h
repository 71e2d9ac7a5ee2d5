// Rolling shutter: row y is exposed later than row 0 by y / rows of the readout time. Value type, reentrant.
#pragma once

#include <chrono>

#include "hal/core/instant.h"

namespace hdrcam {

struct RollingShutterSettings {
  Duration readout = std::chrono::milliseconds(12);  // of all rows
};

class RollingShutter {
 public:
  RollingShutter(RollingShutterSettings settings, int rows)
      : readout_(settings.readout), row_time_s_(to_seconds(settings.readout) / rows) {}

  Duration readout() const { return readout_; }
  double delay_s(int row) const { return row * row_time_s_; }

 private:
  Duration readout_;
  double row_time_s_;
};

}  // namespace hdrcam
