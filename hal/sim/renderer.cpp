#include "hal/sim/renderer.h"

namespace hdrcam {
namespace {

void put(Image<float>& image, int y, int x, Colour value) {
  image.at(0, y, x) = value.x, image.at(1, y, x) = value.y, image.at(2, y, x) = value.z;
}

}  // namespace

Renderer::Renderer(const Scene& scene, Lens lens, Shutter shutter, int rows, int cols, WorkerPool& pool)
    : scene_(scene),
      lens_(lens),
      shutter_(shutter),
      rows_(rows),
      cols_(cols),
      pool_(pool),
      views_(kMostViews) {
  tile_blur_ = Image<float>(1, (rows + kTile - 1) / kTile, (cols + kTile - 1) / kTile);
  spread_blur_ = Image<float>(1, tile_blur_.rows(), tile_blur_.cols());
  for (View& view : views_) view.pose_at(scene, 0);
}

void Renderer::pose_views(double begin_s, double end_s) {
  constexpr double kStep_s = 0.25e-3;  // half a pixel at 2000 px/s
  const double steps = scene_.moves() ? std::ceil((end_s - begin_s) / kStep_s) : 0;
  view_count_ = 1 + static_cast<int>(std::min<double>(steps, kMostViews - 1));
  first_s_ = begin_s;
  step_s_ = view_count_ > 1 ? (end_s - begin_s) / (view_count_ - 1) : 0;
  for (int i = 0; i < view_count_; ++i)
    views_[static_cast<std::size_t>(i)].pose_at(scene_, begin_s + i * step_s_);
}

const View& Renderer::view_at(double time_s) const {
  if (view_count_ == 1) return views_[0];
  const long nearest = std::lround((time_s - first_s_) / step_s_);
  return views_[static_cast<std::size_t>(std::clamp<long>(nearest, 0, view_count_ - 1))];
}

void Renderer::render(ExposureSpan span, Image<float>& light) {
  light.reshape(3, rows_, cols_);
  if (!shutter_.blur) span.begin_s = span.end_s = (span.begin_s + span.end_s) / 2;
  pose_views(span.begin_s, span.end_s + row_delay_s(rows_));
  const bool blurs = shutter_.blur && view_count_ > 1;
  if (blurs) measure_blur(span), spread_blur();
  pool_.for_rows(rows_, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y)
      for (int x = 0; x < cols_; ++x) {
        const int along_motion = blurs ? shutter_.blur->samples(spread_blur_.at(0, y / kTile, x / kTile)) : 1;
        put(light, y, x, mean_radiance(span, y, x, std::max(along_motion, kLeastSamples)));
      }
  });
}

// How far the points of each tile travel through the picture during the exposure.
void Renderer::measure_blur(ExposureSpan span) {
  const float focal_px = static_cast<float>(lens_.intrinsics.fx_px);
  pool_.for_each(tile_blur_.rows(), [&](int tile_y) {
    std::fill_n(tile_blur_.row(0, tile_y), tile_blur_.cols(), 0.f);
    for (int y = tile_y * kTile; y < std::min(rows_, (tile_y + 1) * kTile); y += kProbe) {
      const double delay_s = row_delay_s(y);
      const View& middle = view_at((span.begin_s + span.end_s) / 2 + delay_s);
      const View& begin = view_at(span.begin_s + delay_s);
      const View& end = view_at(span.end_s + delay_s);
      for (int x = 0; x < cols_; x += kProbe) {
        const Hit hit = middle.cast(lens_.ray_of(static_cast<float>(x), static_cast<float>(y)));
        const Vec3 from = begin.project(hit.object, hit.point), to = end.project(hit.object, hit.point);
        float& most = tile_blur_.at(0, tile_y, x / kTile);
        most = std::max(most, focal_px * std::hypot(to.x - from.x, to.y - from.y));
      }
    }
  });
}

// A moving thing blurs over its neighbours as far as it moves.
void Renderer::spread_blur() {
  const int tile_rows = tile_blur_.rows(), tile_cols = tile_blur_.cols();
  spread_blur_.fill(0);
  for (int y = 0; y < tile_rows; ++y)
    for (int x = 0; x < tile_cols; ++x) {
      const float own = tile_blur_.at(0, y, x);
      if (own <= MotionBlur::kSharp_px) continue;
      const int reach = 1 + static_cast<int>(std::min(own, 1e4f)) / (2 * kTile);
      for (int v = std::max(0, y - reach); v <= std::min(tile_rows - 1, y + reach); ++v)
        for (int u = std::max(0, x - reach); u <= std::min(tile_cols - 1, x + reach); ++u)
          spread_blur_.at(0, v, u) = std::max(spread_blur_.at(0, v, u), own);
    }
}

// Over the pixel and its exposure. Where the samples fall on more than one surface, they are doubled once.
Colour Renderer::mean_radiance(ExposureSpan span, int y, int x, int samples) const {
  const float footprint = 0.5f / static_cast<float>(lens_.intrinsics.fx_px);
  const double delay_s = row_delay_s(y), length_s = span.end_s - span.begin_s;
  const int most = 2 * samples;
  Colour sum;
  int first_surface = -1;
  bool outline = false;
  int taken = 0;
  for (; taken < (outline ? most : samples); ++taken) {
    const int k = taken % samples;  // the second half lies at other places at the same instants
    const View& view = view_at(span.begin_s + delay_s + length_s * MotionBlur::fraction(k, samples));
    const Vec2 place = samples_.place(taken, samples);
    const Hit hit = view.cast(lens_.ray_of(static_cast<float>(x) + place.x, static_cast<float>(y) + place.y));
    sum = sum + view.radiance(hit, footprint);
    const int surface = 8 * hit.object + hit.part;
    outline |= taken > 0 && surface != first_surface;
    if (taken == 0) first_surface = surface;
  }
  return sum * (1 / static_cast<float>(taken));
}

}  // namespace hdrcam
