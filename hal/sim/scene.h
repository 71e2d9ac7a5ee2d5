// A scene: analytic objects with procedural HDR surfaces, lamps, rigid and pulsating motion, surroundings at
// a finite distance, and a camera path. Everything is a function of time; nothing is stepped, so instants can
// be evaluated in any order. World axes as the camera's at rest: x right, y down, z forward; metres.
// Immutable once made, so reentrant.
#pragma once

#include <string>
#include <vector>

#include "hal/sim/camera_path.h"
#include "hal/sim/geometry.h"
#include "hal/sim/texture.h"

namespace hdrcam {

enum class Shape { Ball, Box, Panel, Ground, Dome };  // Panel: a rectangle facing z; Ground: a disc facing up
enum class Surface {
  Radiant,  // the texture is the radiance, whatever the light; brightness constancy holds
  Lit,      // the texture is an albedo under the ambient light and the lamps
  Lamp,     // one colour; it lights the Lit objects
};

struct ObjectMotion {
  Vec3 swing_m, swing_hz, swing_phase_rad;  // of the centre, per axis
  Vec3 axis{0, 1, 0};
  float angle_rad = 0, turn_rad_per_s = 0;
  float pulse = 0, pulse_hz = 0;  // relative size: 1 + pulse sin
};

struct SceneObject {
  Shape shape = Shape::Ball;
  Surface surface = Surface::Radiant;
  Vec3 half_size_m{1, 1, 1};  // Ball, Dome, Ground: x is the radius
  Vec3 centre_m;
  ObjectMotion motion;
  int texture = 0;  // index into Scene::textures; not for Dome and Lamp
  float tiles_per_m = 1;
  float gain = 1;  // of the radiance or albedo
  Colour colour{1, 1, 1};

  bool moves() const;
};

struct PosedObject {
  Pose T_world_object;
  float size = 1;  // pulse
};
PosedObject pose_of(const SceneObject& object, double time_s);

struct Scene {
  std::string name;
  static constexpr int kDome = 0;    // the first object is the dome; all others lie within it
  std::vector<SceneObject> objects;  // at most 255: ids are bytes
  std::vector<Texture> textures;     // of Radiant objects and, as their albedo(), of Lit ones
  Panorama panorama;                 // painted on Shape::Dome
  CameraPath camera;
  Colour ambient{0.5f, 0.5f, 0.5f};     // light on Lit surfaces from everywhere..
  Colour from_above{0.5f, 0.5f, 0.5f};  // ..and more from above
  float radiance_scale = 1;             // sets the median luminance of the first view

  bool moves() const;  // whether any object or the camera moves
};

}  // namespace hdrcam
