// Evaluates the field along rays without gradients, for all renderers and the depth guide. A probe owns the
// buffers of one batch, so each thread has its own; the field is only read.
#pragma once

#include <span>

#include "online/scene/hash_grid/field/radiance_field.h"
#include "online/scene/hash_grid/field/ray_rendering.h"

namespace hdrcam {

// Pose and time of a view. Between frames dynamic content moves along the nearest frame's scene flow.
struct ProbeView {
  RigidTransform T_anchor_camera;
  int frame = 0;     // position in the window of the frame nearest in time
  float offset = 0;  // intervals after (+) or before (-) that frame, -0.5..0.5
};

struct ProbeRay {
  float pixel[2];
  float guide;  // inverse depth around which samples are placed
};

struct ProbeAnswer {
  float radiance[3];
  float inverse_depth;
  float confidence;  // 0..1: the state's share of the radiance, against the networks'; 0 outside
                     // its picture
  float flow[2][2];  // by Neighbour: pixels, to the view of the next and of the previous frame
};

class FieldProbe {
 public:
  static constexpr int kRays = 32;

  FieldProbe(const FieldNetworks<float>& networks, int most_samples);

  // rays.size() <= kRays; answers has the same size.
  void look(const RadianceField& field, const ProbeView& view, std::span<const ProbeRay> rays,
            std::span<ProbeAnswer> answers);

 private:
  struct Cameras;
  struct StateShares;

  void place(const RadianceField& field, const ProbeView& view, std::span<const ProbeRay> rays);
  void move_to_frame(const Cameras& cameras, const ProbeView& view, int rays);
  void decode(const Cameras& cameras, const ProbeView& view, int r, StateShares& known);
  ProbeAnswer answer(const Cameras& cameras, Blend blend, const ProbeRay& probe, int r,
                     const StateShares& known) const;

  BranchPass<float> static_, dynamic_;
  std::vector<RaySamples<float>> ray_;
};

}  // namespace hdrcam
