#include "online/scene/scene_fields.h"

#include "hal/sections/section_file.h"
#include "online/scene/hash_grid/hash_grid_field.h"

namespace hdrcam {

int field_step_px(FieldStep step, int rows, int cols) {
  if (step != FieldStep::Auto) return 1 << (static_cast<int>(step) - static_cast<int>(FieldStep::One));
  constexpr double kMostPixels = 60'000;  // of the field
  int side = 2;
  while (side < 8 && static_cast<double>(rows) * cols > kMostPixels * side * side) side *= 2;
  return side;
}

std::unique_ptr<SceneField> make_scene_field(FieldKind kind, const FieldOptions& hash_grid,
                                             const SceneSetup& setup, WorkerPool& pool) {
  switch (kind) {
    case FieldKind::None:
      break;
    case FieldKind::HashGrid:
      return std::make_unique<HashGridField>(hash_grid, setup, pool);
  }
  return nullptr;
}

Result<std::unique_ptr<FieldSnapshot>> load_field(SectionReader& file, GpuDevice* gpu) {
  if (TRY(file.next()) == HashGridSnapshot::kSection) return HashGridSnapshot::load(file, gpu);
  return file.wrong("no kind of field is called so");
}

}  // namespace hdrcam
