// The kinds of fields by name: a new one has a folder beside this file, a word here and a line in
// make_scene_field().
#pragma once

#include "hal/gpu/gpu_device.h"
#include "online/scene/hash_grid/fit/field_options.h"
#include "online/scene/scene_field.h"

namespace hdrcam {

enum class FieldKind { None, HashGrid };

// Settings of every field, fixed at the start.
struct SceneSetup {
  Intrinsics lens;
  int rows = 0, cols = 0;
  float near = 1;            // distance of the near plane, in the poses' unit
  GpuDevice* gpu = nullptr;  // renders views of the field; null for the processor; outlives the field
};

// Returns null for None: the state alone.
std::unique_ptr<SceneField> make_scene_field(FieldKind kind, const FieldOptions& hash_grid,
                                             const SceneSetup& setup, WorkerPool& pool);

}  // namespace hdrcam
