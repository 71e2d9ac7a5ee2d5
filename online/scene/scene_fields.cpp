#include "online/scene/scene_fields.h"

#include "online/scene/hash_grid/hash_grid_field.h"

namespace hdrcam {

std::unique_ptr<SceneField> make_scene_field(FieldKind kind, const FieldOptions& hash_grid,
                                             const SceneSetup& setup, WorkerPool& pool) {
  switch (kind) {
    case FieldKind::None:
      break;
    case FieldKind::HashGrid:
      return std::make_unique<HashGridField>(hash_grid, setup.near, setup.lens, setup.rows, setup.cols, pool,
                                             setup.gpu);
  }
  return nullptr;
}

}  // namespace hdrcam
