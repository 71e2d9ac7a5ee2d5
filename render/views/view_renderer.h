// The scene from any view at any moment between two emitted frames: their full-size pictures are moved along
// their motion to the moment and along their depth to the view, nearer surfaces cover farther ones, and what
// neither shows is filled from the field and marked so (Provenance::Field). With the frame's own view and
// time the picture is the frame's own. Thread-bound; deterministic for any number of threads.
#pragma once

#include <array>

#include "render/views/keyframe_interval.h"
#include "render/views/warp_mesh.h"

namespace hdrcam {

class ViewRenderer {
 public:
  explicit ViewRenderer(WorkerPool& pool) : pool_(pool) {}

  // view: pose, lens and size; its time is the interval's. field: fills holes; where it is empty they stay
  // black. Sets radiance, sigma, provenance, depth (none where a keyframe knows none) and white of `frame`,
  // and leaves it without motion.
  void render(const KeyframeInterval& interval, const SceneView& view, const SnapshotHold& field,
              HdrFrame& frame);

 private:
  struct Source {
    const Keyframe* key = nullptr;
    MeshVertices vertices;
    MeshAnswer answer;
  };

  // toward: its frame's motion to the other one, of which the scene has gone `share`.
  void draw(const FlowField& toward, float share, const RigidTransform& T_view_recorded,
            const SceneView& view, Source& source);
  void blend(const KeyframeInterval& interval, HdrFrame& frame);
  void fill(const SceneView& view, const SnapshotHold& field, float depth_unit, HdrFrame& frame);

  WorkerPool& pool_;
  std::array<Source, 2> sources_;  // before, after
  Image<std::uint8_t> holes_;      // [1, rows, cols] of the view
  FieldPicture picture_;
};

}  // namespace hdrcam
