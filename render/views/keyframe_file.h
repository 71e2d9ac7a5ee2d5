// Keyframes in a file (docs/snapshot.md): their small values as fields, their pictures as one section each,
// to the bit. The motion of the state, which only the search of keyframe_motion.h starts from, is left out.
// Reentrant.
#pragma once

#include "hal/sections/fact_fields.h"
#include "hal/sections/section_file.h"
#include "render/views/keyframe.h"

namespace hdrcam {

template <Either<FramePose> Pose>
void list_fields(auto& fields, Pose& pose) {
  fields(pose.T_world_camera);
  fields.word(pose.source, PoseSource::Fixed);
  fields(pose.lost, pose.world);
}

template <Either<HdrFrameHead> Head>
void list_fields(auto& fields, Head& head) {
  fields(head.facts, head.exposure, head.reference_exposure, head.white, head.neutral_gains,
         head.white_balance, head.pose);
  fields.word(head.length_unit, LengthUnit::Unknown);
  fields(head.lens, head.lens_is_assumed);
}

template <Either<Keyframe> Key>
void list_fields(auto& fields, Key& key) {
  fields(key.frame.head(), key.time_s, key.T_world_camera, key.world, key.lens, key.depth_unit);
}

// A whole keyframe. Errors: those of the disk.
Result<void> save_pictures(const Keyframe& key, SectionWriter& file);
// rows, cols: of the pictures. Errors: those of SectionReader; Corrupt for values that no picture has.
Result<void> load_pictures(SectionReader& file, int rows, int cols, Keyframe& key);

}  // namespace hdrcam
