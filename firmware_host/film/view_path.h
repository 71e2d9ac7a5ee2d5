// How a virtual camera stands to the recorded one, over time: the texts and files of --view and --path become
// poses. Camera axes: x right, y down, z forward. Angles in degrees: yaw to the right, pitch up, roll
// clockwise, turned in that order. Lengths are in the scene's unit (metres where the recording has poses,
// else the median depth of its first frame); one with a unit ("63mm") needs metres. Plain values, reentrant.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "hal/core/geometry.h"
#include "hal/core/result.h"
#include "hal/storage.h"

namespace hdrcam {

// A length as it was given.
struct SceneLength {
  double value = 0;        // in the scene's unit
  bool in_metres = false;  // a unit was given
};
// "63mm", "6.3cm", "0.063m" or "0.063". Invalid, naming the flag.
Result<SceneLength> parse_length(std::string_view flag, std::string_view text);

// The virtual camera at a moment, as the recorded camera sees it.
struct ViewOffset {
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();     // right, down, forward
  Eigen::Vector3d turn_deg = Eigen::Vector3d::Zero();  // yaw, pitch, roll

  RigidTransform T_recorded_view() const;
  bool in_place() const { return shift.isZero(0) && turn_deg.isZero(0); }
};

class ViewPath {
 public:
  // "dx,dy,dz" or "dx,dy,dz,yaw,pitch,roll": the same pose at any time. "": in place.
  static Result<ViewPath> parse_view(std::string_view text);
  // A file of poses over playback time, as CSV with a line of names (time_s,dx,dy,dz,yaw,pitch,roll; those
  // left out are 0) or as JSON, an array of objects with these names. Errors: those of reading; Invalid,
  // naming the line or the entry.
  static Result<ViewPath> read_path(Storage& storage, const std::string& path);

  // The pose at a playback time: a smooth curve through the poses given; the first and the last hold before
  // and after.
  ViewOffset at(double playback_s) const;
  double end_s() const { return poses_.back().time_s; }  // of the last pose
  bool is_path() const { return poses_.size() > 1; }
  bool in_place() const;
  bool in_metres() const { return in_metres_; }

 private:
  struct Pose {
    double time_s = 0;
    ViewOffset offset;
  };
  static Result<ViewPath> of(std::vector<Pose> poses, const std::string& path);

  std::vector<Pose> poses_{1};
  bool in_metres_ = false;
};

}  // namespace hdrcam
