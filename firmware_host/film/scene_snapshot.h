// A scene as a run left it, in a file of its own (docs/snapshot.md): its last frames with their depth, motion
// and cameras, the field of its last moment and the response, which is all that a virtual camera needs. What
// it films of them is what it would film of the run, to the bit. Move-only value.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/exposed_frame.h"
#include "firmware_host/film/film_plan.h"
#include "hal/gpu/gpu_device.h"
#include "hal/sections/section_file.h"
#include "online/response/response.h"
#include "online/scene/field_snapshot.h"
#include "render/views/keyframe.h"

namespace hdrcam {

// The recorded camera at an earlier moment: what steady_path.h smooths over.
struct PathPose {
  double time_s = 0;
  RigidTransform T_world_camera;
  int world = 0;
};

struct SceneHead {
  std::string program;           // that saved it: "hdrcam 1.2.3"
  CameraFacts camera;            // of the run
  Instant first;                 // time stamp of the run's first frame, from which times count
  std::vector<PathPose> path;    // before the frames
  std::vector<Keyframe> frames;  // oldest first; without their pictures in a head that was read alone
  ExposedFrame input;            // that the newest was made of
  bool has_field = false;
};

struct SceneSnapshot : SceneHead {
  std::optional<Response> response;
  std::unique_ptr<FieldSnapshot> field;  // null where there is none

  SceneHead& head() { return *this; }
};

// Whether the file begins as a snapshot of a scene does, whatever its name. Errors: those of reading.
Result<bool> is_scene_snapshot(Storage& storage, const std::string& path);

// gpu: which looks into the field, null for the processor; outlives the snapshot. Errors: those of
// SectionReader; Corrupt for values that no scene has.
Result<SceneSnapshot> load_scene(Storage& storage, const std::string& path, GpuDevice* gpu = nullptr);

// The first section alone, and the checksums of all others. Errors: those of load_scene, as far as values
// were read.
Result<SceneHead> check_scene(Storage& storage, const std::string& path);
// The first section alone.
Result<SceneHead> scene_head(Storage& storage, const std::string& path);

// The newest frame that has a pose: given ones may be missing of some; null where none has one.
const Keyframe* newest_posed(const SceneHead& scene);
// What a film of it is planned by.
FilmedRecording filmed(const SceneHead& scene);

// Writes one, piece by piece, so that its pictures need not be there at once: the head, then the response,
// the frames, the input's codes and the field. Thread-bound.
class SceneWriter {
 public:
  // Errors of all: those of SectionWriter.
  static Result<SceneWriter> create(FileInMaking making, const SceneHead& head, const Response& response);
  Result<void> add(const Keyframe& frame);
  Result<void> finish(const ExposedFrame& input, const SnapshotHold& field);

 private:
  explicit SceneWriter(SectionWriter file) : file_(std::move(file)) {}

  SectionWriter file_;
};

}  // namespace hdrcam
