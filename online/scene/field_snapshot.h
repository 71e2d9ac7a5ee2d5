// A field at one moment, for rendering. It is immutable: while one thread renders a snapshot, another may
// take the next step of the fit. A reader holds it (SnapshotHold); the field reuses a snapshot only when no
// reader holds it, so that neither waits for the other and nothing is allocated per frame.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <utility>

#include "hal/core/frame.h"
#include "hal/core/geometry.h"
#include "hal/core/image.h"
#include "hal/core/result.h"
#include "hal/core/worker_pool.h"
#include "online/pictures/flow_field.h"

namespace hdrcam {

class SectionWriter;  // hal/sections/section_file.h

// Pose, time, lens and size of a picture. Pixels of the view are those of its lens, centres at +0.5.
struct SceneView {
  RigidTransform T_world_camera;
  double time_s = 0;      // centre of the exposure; clamped to the field's window
  double exposure_s = 0;  // the picture is the mean over this interval around time_s; 0: an instant
  Intrinsics lens;
  int rows = 0, cols = 0;  // 1..
  // [1, rows, cols]: pixels of value 0 are not asked for, a field may leave them 0; null: all are asked for
  const Image<std::uint8_t>* wanted = nullptr;
};

// The same view with one pixel per step x step pixels.
SceneView reduced(const SceneView& view, int step);

// Buffers that a kind of snapshot needs for rendering, kept between calls.
struct RenderBuffers {
  virtual ~RenderBuffers() = default;
};

// The rendered view; all images are [n, rows, cols] of the view. The caller keeps it, so that reusing a
// picture allocates nothing.
struct FieldPicture {
  Image<float> radiance;  // [rgb] finite, >= 0
  Image<float> depth;     // [1] camera z, >= 1, in units of the field's near plane
  // [dx dy] by Neighbour: px, to the view of the next and of the previous frame.
  std::array<Image<float>, 2> flow;
  Image<float> confidence;  // [1] 0..1: the state's share; 0 where the field alone gives the radiance
  std::unique_ptr<RenderBuffers> buffers;
};

class FieldSnapshot {
 public:
  virtual ~FieldSnapshot() = default;

  // Renders the view. Reentrant, each caller with its own picture and pool.
  virtual void look(const SceneView& view, WorkerPool& pool, FieldPicture& picture) const = 0;
  // Adds all that look() needs to a file (scene_fields.h reads it). Reentrant. Errors: those of the disk;
  // Unsupported where this kind of field has no place in a file.
  virtual Result<void> save(SectionWriter& file) const;
  bool is_held() const { return holders_.load(std::memory_order_acquire) > 0; }

 private:
  friend class SnapshotHold;
  mutable std::atomic<int> holders_{0};
};

// Keeps a snapshot unchanged during its lifetime; empty where there is no field. The field must outlive it.
class SnapshotHold {
 public:
  SnapshotHold() = default;
  explicit SnapshotHold(const FieldSnapshot& held) : held_(&held) { ++held_->holders_; }
  SnapshotHold(const SnapshotHold& other) : held_(other.held_) {
    if (held_ != nullptr) ++held_->holders_;
  }
  SnapshotHold(SnapshotHold&& other) noexcept : held_(std::exchange(other.held_, nullptr)) {}
  SnapshotHold& operator=(SnapshotHold other) noexcept {
    std::swap(held_, other.held_);
    return *this;
  }
  ~SnapshotHold() {
    if (held_ != nullptr) held_->holders_.fetch_sub(1, std::memory_order_release);
  }

  explicit operator bool() const { return held_ != nullptr; }
  const FieldSnapshot* operator->() const { return held_; }

 private:
  const FieldSnapshot* held_ = nullptr;
};

}  // namespace hdrcam
