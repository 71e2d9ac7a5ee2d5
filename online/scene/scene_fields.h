// The kinds of fields there are, by name: a new one has a folder beside this file, a word here and a line in
// make_scene_field().
#pragma once

#include "online/scene/hash_grid/fit/field_options.h"
#include "online/scene/scene_field.h"

namespace hdrcam {

enum class FieldKind { None, HashGrid };

// What any field has to know from the start.
struct SceneSetup {
  Intrinsics lens;
  int rows = 0, cols = 0;
  float near = 1;  // where what is near the camera begins, in the poses' unit
};

// Null for None: the state alone.
std::unique_ptr<SceneField> make_scene_field(FieldKind kind, const FieldOptions& hash_grid,
                                             const SceneSetup& setup, WorkerPool& pool);

}  // namespace hdrcam
