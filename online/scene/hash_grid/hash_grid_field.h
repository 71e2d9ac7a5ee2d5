// The scene as a windowed field of two hash grids with small networks, volume rendered: the first
// implementation of SceneField (field/README.md, fit/README.md). Its snapshots copy the networks and hold the
// window's frames, which are reused only when no snapshot holds them (field/window.h). The field is
// thread-bound, a snapshot reentrant.
#pragma once

#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "hal/gpu/gpu_device.h"
#include "hal/sections/section_file.h"
#include "online/scene/hash_grid/fit/field_fit.h"
#include "online/scene/scene_field.h"

namespace hdrcam {

class HashGridSnapshot final : public FieldSnapshot {
 public:
  // gpu: which looks, null for the processor; it outlives the snapshot.
  explicit HashGridSnapshot(const FieldFit& fit, GpuDevice* gpu = nullptr);

  void look(const SceneView& view, WorkerPool& pool, FieldPicture& picture) const override;

  static constexpr std::string_view kSection = "hash grid";  // the first that save() adds
  Result<void> save(SectionWriter& file) const override;
  // The file stands in that section. As load_field().
  static Result<std::unique_ptr<FieldSnapshot>> load(SectionReader& file, GpuDevice* gpu);

 private:
  friend class HashGridField;
  HashGridSnapshot(std::vector<std::unique_ptr<WindowFrame>> own_frames, WindowFrames window,
                   FieldNetworks<float> networks, GpuDevice* gpu)
      : own_frames_(std::move(own_frames)),
        window_(std::move(window)),
        networks_(std::move(networks)),
        gpu_(gpu) {}

  std::vector<std::unique_ptr<WindowFrame>> own_frames_;  // of a loaded one; else they are the field's
  WindowFrames window_;
  FieldNetworks<float> networks_;
  int samples_per_ray_ = 1;
  bool has_dynamic_ = false;
  GpuDevice* gpu_;
};

class HashGridField final : public SceneField {
 public:
  HashGridField(const FieldOptions& options, const SceneSetup& setup, WorkerPool& pool);
  ~HashGridField() override;

  Result<void> observe(const SceneObservation& seen) override;
  FitReport fit(const FitBudget& budget) override;
  void restart() override;
  SnapshotHold snapshot() override;
  std::string fallback_reason() const override { return fit_.fallback_reason(); }

 private:
  void spread(const DepthMap& depth);

  WorkerPool& pool_;
  GpuDevice* gpu_;
  FieldFit fit_;
  long frames_ = 0;             // since the first one or the restart
  Image<float> inverse_depth_;  // prior of the newest frame, on the window's pixels
  std::vector<std::unique_ptr<HashGridSnapshot>> snapshots_;  // as many as were ever held at once
};

}  // namespace hdrcam
