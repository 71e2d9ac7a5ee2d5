// The field as pictures: from any pose, at any time in the window, at any resolution. What it shows is finite
// and positive whatever the fit has done. Thread-bound; deterministic whatever the number of threads.
#pragma once

#include "hal/core/worker_pool.h"
#include "online/field/field_probe.h"

namespace hdrcam {

struct FieldViewRequest {
  PoseMatrix T_world_camera = kIdentityPose;
  double time_s = 0;  // clamped to the window
  int step = 1;       // 1..: one ray per step x step pixels, at their centre
};

// All [n, ceil(rows / step), ceil(cols / step)].
struct FieldView {
  Image<float> radiance;  // [rgb]
  Image<float> depth;     // [1] in units of the near plane
  Image<float>
      flow[2];  // [dx dy] by Neighbour: pixels of the full picture, to the next and previous frame's view
  Image<float> dynamic_share;  // [1] 0..1
  Image<float> confidence;  // [1] 0..1: how much is the state's knowledge, 0 where the networks answer alone
};

class FieldRenderer {
 public:
  explicit FieldRenderer(WorkerPool& pool) : pool_(pool) {}

  // The field must have at least one frame.
  void render(const RadianceField& field, const FieldViewRequest& request, FieldView& view);

 private:
  static constexpr int kSplat = 2;  // pixels
  void splat_surface(const RadianceField& field, const ProbeView& from);

  WorkerPool& pool_;
  std::vector<FieldProbe> probes_;
  Image<float>
      guide_;  // [1, rows / kSplat, cols / kSplat] inverse depth of the frame's surface, as the view sees it
};

}  // namespace hdrcam
