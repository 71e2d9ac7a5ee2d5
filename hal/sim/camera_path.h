// The simulated camera's trajectory: a smooth function of time that stays within the scene for ever, so that
// ten thousand frames work as well as ten. Value type, reentrant.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "hal/sim/geometry.h"

namespace hdrcam {

enum class CameraMove { Still, Handheld, Pan, Dolly, Orbit };
const char* name(CameraMove move);
std::optional<CameraMove> camera_move_of(std::string_view name);

class CameraPath {
 public:
  // scale_m: the distance to the middle of the scene, metres; speed 1: a person filming.
  CameraPath(CameraMove move, std::uint64_t seed, float scale_m, float speed);

  CameraMove move() const { return move_; }
  bool moves() const { return move_ != CameraMove::Still && speed_ > 0; }
  // T_world_camera
  Pose at(double time_s) const;

 private:
  // A sum of three sines of irregular frequencies: the tremble of a hand, |value| <= 1.
  struct Tremble {
    std::array<double, 3> frequency_hz{}, phase_rad{};
    float at(double time_s) const;
  };

  CameraMove move_;
  float scale_, speed_;
  std::array<Tremble, 6> trembles_;  // x y z of the position, yaw pitch roll
};

}  // namespace hdrcam
