#include "online/scene/hash_grid/fit/guide_refresh.h"

namespace hdrcam {
namespace {

// inverse depths in whose band (ray_sampler.h) samples still lie on both sides
constexpr float kFarthestGuide = 0.01f, kNearestGuide = 0.95f;

}  // namespace

void refresh_guide(Window& window, const RadianceField& field, FieldProbe& probe) {
  if (window.size() == 0 || !window.has_parallax()) return;
  WindowFrame& frame = window.writable(window.size() - 1);
  const ProbeView view{frame.T_anchor_camera, window.size() - 1, 0};
  ProbeRay rays[FieldProbe::kRays];
  ProbeAnswer answers[FieldProbe::kRays];
  float* guides[FieldProbe::kRays];
  std::size_t waiting = 0;
  const auto look = [&] {
    probe.look(field, view, {rays, waiting}, {answers, waiting});
    for (std::size_t i = 0; i < waiting; ++i)
      *guides[i] = std::clamp(answers[i].inverse_depth, kFarthestGuide, kNearestGuide);
    waiting = 0;
  };
  for (int y = 0; y < frame.guide.rows(); ++y)
    for (int x = 0; x < frame.guide.cols(); ++x) {
      if (frame.prior_guides.at(0, y, x) != 0 || (x + y + frame.index) % 2 != 0) continue;
      float& guide = frame.guide.at(0, y, x);
      rays[waiting] = {{static_cast<float>(x * kGuideStep) + kGuideStep / 2.f,
                        static_cast<float>(y * kGuideStep) + kGuideStep / 2.f},
                       guide};
      guides[waiting++] = &guide;
      if (waiting == FieldProbe::kRays) look();
    }
  if (waiting > 0) look();
}

}  // namespace hdrcam
