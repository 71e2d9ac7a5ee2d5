#include "hal/sim/scene.h"

#include <numbers>

namespace hdrcam {
namespace {

bool any(Vec3 v) { return v.x != 0 || v.y != 0 || v.z != 0; }

float swing(float amplitude, float frequency_hz, float phase_rad, double time_s) {
  if (amplitude == 0) return 0;
  return amplitude * static_cast<float>(std::sin(2 * std::numbers::pi * frequency_hz * time_s + phase_rad));
}

}  // namespace

bool SceneObject::moves() const {
  return any(motion.swing_m) || motion.turn_rad_per_s != 0 || motion.pulse != 0;
}

PosedObject pose_of(const SceneObject& object, double time_s) {
  const ObjectMotion& m = object.motion;
  PosedObject posed;
  posed.T_world_object.position =
      object.centre_m + Vec3{swing(m.swing_m.x, m.swing_hz.x, m.swing_phase_rad.x, time_s),
                             swing(m.swing_m.y, m.swing_hz.y, m.swing_phase_rad.y, time_s),
                             swing(m.swing_m.z, m.swing_hz.z, m.swing_phase_rad.z, time_s)};
  posed.T_world_object.rotation =
      rotation(m.axis, m.angle_rad + static_cast<double>(m.turn_rad_per_s) * time_s);
  posed.size = 1 + swing(m.pulse, m.pulse_hz, 0, time_s);
  return posed;
}

bool Scene::moves() const {
  if (camera.moves()) return true;
  for (const SceneObject& object : objects)
    if (object.moves()) return true;
  return false;
}

}  // namespace hdrcam
