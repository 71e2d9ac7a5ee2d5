#include "hal/sim/scene_truth.h"

namespace hdrcam {

TruthRenderer::TruthRenderer(const Scene& scene, Lens lens, int rows, int cols, WorkerPool& pool,
                             const Vignetting* vignetting)
    : scene_(scene),
      lens_(lens),
      rows_(rows),
      cols_(cols),
      pool_(pool),
      vignetting_(vignetting),
      sharp_(scene, lens, {}, rows, cols, pool) {}

void TruthRenderer::render(double now_s, double next_s, SceneTruth& truth) {
  truth.time_s = now_s;
  sharp_.render({now_s, now_s}, truth.radiance);
  if (vignetting_ != nullptr)
    for (int y = 0; y < rows_; ++y) vignetting_->apply_row(truth.radiance, y);
  truth.depth.reshape(1, rows_, cols_);
  truth.flow.reshape(3, rows_, cols_);
  truth.ids.reshape(1, rows_, cols_);
  now_.pose_at(scene_, now_s);
  next_.pose_at(scene_, next_s);
  truth.T_world_camera = now_.camera();
  pool_.for_rows(rows_, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) trace_row(y, truth);
  });
}

void TruthRenderer::trace_row(int y, SceneTruth& truth) const {
  constexpr float kSameSurface = 2e-3f;  // relative depth
  const float py = static_cast<float>(y) + 0.5f;
  for (int x = 0; x < cols_; ++x) {
    const float px = static_cast<float>(x) + 0.5f;
    const Hit hit = now_.cast(lens_.ray_of(px, py));
    truth.depth.at(0, y, x) = hit.depth_m;
    truth.ids.at(0, y, x) = static_cast<std::uint8_t>(hit.object);
    const Vec3 to = next_.project(hit.object, hit.point);
    const Vec2 pixel = lens_.pixel_of({to.x, to.y});
    const bool inside = to.z > 0 && pixel.x >= 0 && pixel.y >= 0 && pixel.x <= static_cast<float>(cols_) &&
                        pixel.y <= static_cast<float>(rows_);
    const bool seen = inside && next_.cast({to.x, to.y}).depth_m > to.z * (1 - kSameSurface);
    truth.flow.at(0, y, x) = pixel.x - px;
    truth.flow.at(1, y, x) = pixel.y - py;
    truth.flow.at(2, y, x) = seen ? 0.f : 1.f;
  }
}

}  // namespace hdrcam
