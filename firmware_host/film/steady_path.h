// A recorded camera's path without its shake: at each moment the mean of the poses around it, weighted by a
// Gaussian in time. Thread-bound.
#pragma once

#include <deque>

#include "hal/core/geometry.h"

namespace hdrcam {

class SteadyPath {
 public:
  static constexpr double kReach_s = 0.5;  // of the poses before and after that count

  // In the order of their times.
  void add(double time_s, const RigidTransform& T_world_camera);
  // Needs a pose; those up to kReach_s later should be there.
  RigidTransform at(double time_s) const;

 private:
  struct Pose {
    double time_s;
    RigidTransform T_world_camera;
  };
  std::deque<Pose> poses_;
};

}  // namespace hdrcam
