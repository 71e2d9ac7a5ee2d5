// A recorded camera's path without its shake: at each moment the mean of the poses around it, weighted by a
// Gaussian in time. Where tracking began anew, only those of the nearest pose's world count. A frame without
// a pose counts only where no frame has one. Thread-bound.
#pragma once

#include <cstddef>
#include <deque>

#include "hal/core/geometry.h"

namespace hdrcam {

class SteadyPath {
 public:
  static constexpr double kReach_s = 0.5;  // of the poses before and after that count

  enum class Is { Posed, HeldInPlace };  // a frame whose camera is known, or taken to be where it was
  // In the order of their times. world: poses of different ones do not belong together.
  void add(double time_s, const RigidTransform& T_world_camera, int world = 0, Is is = Is::Posed);
  // Needs a pose; those up to kReach_s later should be there.
  RigidTransform at(double time_s) const;
  // No earlier moment is asked for any more.
  void forget_before(double time_s);
  std::size_t poses() const { return poses_.size(); }  // that are kept

 private:
  struct Pose {
    double time_s;
    RigidTransform T_world_camera;
    int world;
    Is is;
  };
  std::deque<Pose> poses_;
};

}  // namespace hdrcam
