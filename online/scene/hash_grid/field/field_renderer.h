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
  static constexpr int kSplat = 2;     // pixels of the window's camera, along either side of a tile
  static constexpr int kInstants = 5;  // of an exposure interval
  static constexpr int kNoFrame = -1;

  // Of a frame's surface, as another view sees it.
  struct Tile {
    float inverse_depth = -1;  // none
    bool at_rest = false;      // its frame's neighbours show the same there
  };
  // Who shows what is in a tile: a frame of the window, in the tile of this column.
  struct Source {
    int frame = kNoFrame, column = 0;
  };
  struct Aim {
    int frame;
    ProbeRay ray;
  };

  void render_instant(const RadianceField& field, const SceneView& view, double time_s, WorkerPool& pool,
                      FieldPicture& picture);
  void aim_rays(const RadianceField& field, const ProbeView& from, const SceneView& view);
  static void splat_surface(const WindowFrustum& frustum, const WindowFrame& frame, const ProbeView& from,
                            Image<Tile>& tiles);
  void find_sources(const RadianceField& field, const ProbeView& from);
  bool find_holes(int nearest, int y);
  void show_background(const WindowFrames& window, int frame, const ProbeView& from);
  void continue_background(int y);
  void look(const RadianceField& field, const ProbeView& from, WorkerPool& pool);
  void look(const RadianceField& field, const ProbeView& from, std::span<const ProbeRay> rays,
            std::span<ProbeAnswer> answers, WorkerPool& pool);
  void fall_back_to_cpu(const Error& why);

  std::vector<FieldProbe> probes_;
  std::unique_ptr<VulkanProbe> gpu_probe_;
  struct Pixel {
    int y, x;
  };
  std::vector<Pixel>
      pixels_;  // that are asked for, by frame and row by row; with them, their rays and answers
  std::vector<ProbeRay> rays_;
  std::vector<ProbeAnswer> answers_;
  std::vector<std::size_t> ends_;  // by frame of the window: of its rays
  Image<float> guide_;             // [1, rows / kSplat, cols / kSplat] inverse depth of what the view sees
  Image<Source> sources_;          // of the same tiles
  Image<Tile> tiles_;              // of one frame
  Image<float> sum_;               // of radiance, over instants
};

}  // namespace hdrcam
