// The named scenes and the settings that vary them. The same settings give the same scene on every machine.
// Immutable; reentrant.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "hal/sim/effect_plan.h"
#include "hal/sim/scene.h"

namespace hdrcam {

struct SceneSettings {
  int scene = 0;  // index into scene_catalog()
  std::uint64_t seed = 1;
  int objects = 4;  // 0..64: boxes, balls and panels; two of three move
  int lamps = 1;    // 0..16
  float speed = 1;  // of all motion, 0..4
  float pulse = 0;  // pulsating balls: relative size, 0..0.5
  CameraMove camera = CameraMove::Still;
};

struct CatalogScene {
  const char* name;
  const char* about;
  SceneSettings settings;  // its defaults
  Environment environment;
  float distance_m;   // to the middle of the scene
  float median;       // luminance of the first view
  float full_well_e;  // of a sensor that suits it
  struct Need {
    Effect effect;
    const char* why;
  };
  std::span<const Need> needs;
};
std::span<const CatalogScene> scene_catalog();

// face_px: texels per side of the surroundings, about as many as the picture has columns.
Scene make_scene(const SceneSettings& settings, int face_px, WorkerPool& pool);

}  // namespace hdrcam
