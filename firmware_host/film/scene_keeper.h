// Keeps the scene of a run's last frames, to save it at the end (scene_snapshot.h): each frame as it was
// emitted, and the field as it was then. Depth and motion are found only when the scene is saved, so that the
// frames of a camera do not wait for them. Thread-bound.
#pragma once

#include <deque>
#include <optional>
#include <string>

#include "firmware_host/film/scene_snapshot.h"
#include "render/views/keyframe_maker.h"

namespace hdrcam {

class SceneKeeper {
 public:
  // frames: how many of the last are kept, 1.. The pool outlives the keeper, and the fields of the run do.
  SceneKeeper(int frames, WorkerPool& pool) : most_(static_cast<std::size_t>(frames)), maker_(pool) {}

  // Where it is saved: what another program writes there from now on is not replaced. Once, before save().
  // The storage outlives the keeper. Errors: those of the disk.
  Result<void> name_file(Storage& storage, const std::string& path);
  // The run's first frame, emitted or not.
  void begin(Instant first) { head_.first = first; }
  void take(const HdrFrame& frame, const FrameEstimate& estimate);
  int frames() const { return static_cast<int>(kept_.size()); }
  // Writes the file and forgets all frames; nothing where there are none. Errors: those of the disk.
  Result<void> save(const CameraFacts& camera, const Response& response);

 private:
  struct Kept {
    Keyframe key;        // without depth and motion
    SnapshotHold field;  // of its moment
  };

  const std::size_t most_;
  KeyframeMaker maker_;
  SceneHead head_;
  std::deque<Kept> kept_;
  std::optional<FileInMaking> making_;  // once it is named
};

// Memory for such frames of pictures of this size, and for the fields' snapshots of their moments.
std::uint64_t kept_scene_bytes(int width, int height, int frames, int field_step_px);

}  // namespace hdrcam
