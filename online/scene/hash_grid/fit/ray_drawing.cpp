#include "online/scene/hash_grid/fit/ray_drawing.h"

namespace hdrcam {
namespace {

// The pixel of the neighbour to which the flow prior leads. Of a ray whose frame, pixel and guide are known.
void follow_flow(const Window& window, const TrainingRay& ray, Neighbour toward, float landing[2]) {
  const auto n = static_cast<std::size_t>(toward);
  const WindowFrame& here = window.frame(ray.frame);
  const WindowFrame& there = window.frame(neighbour_of(ray.frame, toward));
  const BasePixel& base = here.base.at(0, static_cast<int>(ray.pixel[1]), static_cast<int>(ray.pixel[0]));
  float x[3];
  ViewGeometry<float>(window.frustum(), here.T_anchor_camera).place(ray.pixel, ray.guide, x);
  x[0] += base[kBaseFlow + 2 * n] * static_cast<float>(window.frustum().u_per_px());
  x[1] += base[kBaseFlow + 2 * n + 1] * static_cast<float>(window.frustum().v_per_px());
  float seen[3];
  ViewGeometry<float>(window.frustum(), there.T_anchor_camera).project(x, seen, nullptr);
  for (int a = 0; a < 2; ++a) landing[a] = seen[a];
}

void aim_at_neighbour(const Window& window, const BasePixel& base, TrainingRay& ray) {
  follow_flow(window, ray, ray.toward, ray.flow_prior);
  const auto cols = static_cast<float>(window.frustum().cols),
             rows = static_cast<float>(window.frustum().rows);
  ray.warps = ray.flow_prior[0] >= 0 && ray.flow_prior[1] >= 0 && ray.flow_prior[0] < cols &&
              ray.flow_prior[1] < rows;
  ray.flow_confidence = base[kBaseConfidence + static_cast<std::size_t>(ray.toward)];
}

// The ray of a pixel; `random` chooses the neighbour where there are two.
TrainingRay ray_at(const Window& window, int index, int x, int y, bool has_dynamic, Pcg32& random) {
  const WindowFrame& frame = window.frame(index);
  const BasePixel& base = frame.base.at(0, y, x);
  TrainingRay ray;
  ray.frame = index;
  ray.pixel[0] = static_cast<float>(x) + 0.5f, ray.pixel[1] = static_cast<float>(y) + 0.5f;
  ray.guide = base[kBaseSurface];
  for (int c = 0; c < 3; ++c) {
    ray.values[c] = frame.values.at(c, y, x);
    ray.state_log_radiance[c] = base[kBaseLogRadiance + static_cast<std::size_t>(c)];
    ray.state_trust[c] = 1 - base[kBaseGate + static_cast<std::size_t>(c)];
  }
  if (!frame.depth_prior.empty()) {
    ray.depth_prior = frame.depth_prior.at(0, y, x);
    ray.depth_confidence = std::isfinite(ray.depth_prior) ? 1.f : 0.f;
  }
  const bool next = index + 1 < window.size() && frame.knows_flow(Neighbour::Next);
  const bool previous = index > 0 && frame.knows_flow(Neighbour::Previous);
  if (next || previous) {  // the picture's motion, the camera's included
    float end[2];
    follow_flow(window, ray, previous ? Neighbour::Previous : Neighbour::Next, end);
    const float blur_px = std::hypot(end[0] - ray.pixel[0], end[1] - ray.pixel[1]) * frame.blur_fraction;
    ray.sharpness = 1 / (1 + blur_px * blur_px);
  }
  if (has_dynamic && (next || previous)) {
    ray.toward = next && (!previous || random.below(2) == 0) ? Neighbour::Next : Neighbour::Previous;
    aim_at_neighbour(window, base, ray);
  }
  return ray;
}

}  // namespace

void draw_rays(const Window& window, const RayDrawing& how, std::span<const PixelPicker> pickers,
               Pcg32& random, std::span<TrainingRay> rays) {
  const std::size_t shards = rays.size() / kRaysPerShard;
  const auto newest = static_cast<std::size_t>(how.newest_share * static_cast<float>(rays.size()));
  for (std::size_t r = 0; r < rays.size(); ++r) {
    const int frame = r < newest ? window.size() - 1 : random.below(window.size());
    const auto [x, y] = pickers[static_cast<std::size_t>(window.frame(frame).slot)].pick(random);
    // interleaved over the shards, so that each has a fair part of the newest frame
    rays[r % shards * kRaysPerShard + r / shards] = ray_at(window, frame, x, y, how.has_dynamic, random);
  }
}

void learn_misfits(const Window& window, std::span<const TrainingRay> rays, std::span<const float> misfits,
                   std::span<PixelPicker> pickers) {
  for (std::size_t r = 0; r < rays.size(); ++r)
    pickers[static_cast<std::size_t>(window.frame(rays[r].frame).slot)].learn(
        static_cast<int>(rays[r].pixel[0]), static_cast<int>(rays[r].pixel[1]), misfits[r]);
}

}  // namespace hdrcam
