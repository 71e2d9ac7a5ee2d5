// What a keyframe has besides its picture and its camera: depth, as the field saw it then, smooth on
// surfaces, and the motion from the keyframe before. It need not be found when the frame is emitted, as long
// as the field's snapshot of that moment is held. Thread-bound; the answer does not depend on the number of
// threads.
#pragma once

#include "online/scene/field_snapshot.h"
#include "render/views/depth_edges.h"
#include "render/views/keyframe.h"
#include "render/views/keyframe_motion.h"

namespace hdrcam {

class KeyframeMaker {
 public:
  explicit KeyframeMaker(WorkerPool& pool) : pool_(pool), edges_(pool), motion_(pool) {}

  // key: of take_keyframe(); field: of its moment, empty where there is none; before: the whole keyframe
  // before it, null at the first.
  void complete(const SnapshotHold& field, const Keyframe* before, Keyframe& key);

 private:
  void take_depth(const SnapshotHold& field, Keyframe& key);

  WorkerPool& pool_;
  DepthEdges edges_;
  KeyframeMotion motion_;
  FieldPicture own_view_;
};

}  // namespace hdrcam
