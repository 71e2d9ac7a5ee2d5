// The kinds of fields by name: a new one has a folder beside this file, a word here and a line in
// make_scene_field(). Reentrant.
#pragma once

#include "hal/gpu/gpu_device.h"
#include "online/scene/scene_field.h"

namespace hdrcam {

class SectionReader;  // hal/sections/section_file.h
struct FieldOptions;  // hash_grid/fit/field_options.h

enum class FieldKind { None, HashGrid };

// The blocks of the stream's pixels that are one pixel of a field.
enum class FieldStep { Auto, One, Two, Four, Eight };
// The side of a block for a stream of this size, px. Auto: what serves a field that only fills unseen pixels;
// 2 at 320x240, 4 at 640x480, 8 at 1920x1080, so that a block is about as large in the scene.
int field_step_px(FieldStep step, int rows, int cols);

// Returns null for None: the state alone.
std::unique_ptr<SceneField> make_scene_field(FieldKind kind, const FieldOptions& hash_grid,
                                             const SceneSetup& setup, WorkerPool& pool);

// The field that FieldSnapshot::save wrote, from where the file stands. gpu: which looks, null for the
// processor; outlives the field. Errors: those of SectionReader; Corrupt for values that cannot be.
Result<std::unique_ptr<FieldSnapshot>> load_field(SectionReader& file, GpuDevice* gpu);

}  // namespace hdrcam
