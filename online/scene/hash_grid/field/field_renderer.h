// Renders the field from any pose, at any time in the window, through any lens and at any size. Its pictures
// are finite and positive whatever the fit has done. It owns its buffers, so each rendering thread needs one;
// deterministic for any number of threads of the pool.
#pragma once

#include "hal/core/worker_pool.h"
#include "hal/gpu/gpu_device.h"
#include "online/scene/field_snapshot.h"
#include "online/scene/hash_grid/field/field_probe.h"

namespace hdrcam {

class VulkanProbe;

class FieldRenderer final : public RenderBuffers {
 public:
  // gpu: which looks along the rays, null for the processor. When it fails, the processor goes on.
  explicit FieldRenderer(GpuDevice* gpu = nullptr);
  ~FieldRenderer() override;

  // The field must have at least one frame, and the layers of the first one rendered, whose sizes the buffers
  // keep. With an exposure interval the radiance is the mean over instants in it; everything else belongs to
  // its centre.
  void render(const RadianceField& field, const SceneView& view, WorkerPool& pool, FieldPicture& picture);

 private:
  static constexpr int kSplat = 2;     // pixels of the window's camera
  static constexpr int kInstants = 5;  // of an exposure interval

  void render_instant(const RadianceField& field, const SceneView& view, double time_s, WorkerPool& pool,
                      FieldPicture& picture);
  void aim_rays(const RadianceField& field, const ProbeView& from, const SceneView& view);
  void splat_surface(const RadianceField& field, const ProbeView& from);
  void look(const RadianceField& field, const ProbeView& from, WorkerPool& pool);
  void fall_back_to_cpu(const Error& why);

  std::vector<FieldProbe> probes_;
  std::unique_ptr<VulkanProbe> gpu_probe_;
  struct Pixel {
    int y, x;
  };
  std::vector<Pixel> pixels_;  // that are asked for, row by row; with them, their rays and answers
  std::vector<ProbeRay> rays_;
  std::vector<ProbeAnswer> answers_;
  Image<float> guide_;  // [1, rows / kSplat, cols / kSplat] inverse depth of the frame's surface, as the view
                        // sees it, in pixels of the window's camera
  Image<float> sum_;    // of radiance, over instants
};

}  // namespace hdrcam
