#include "hal/sim/renderer.h"

#include <array>
#include <limits>

namespace hdrcam {
namespace {

constexpr float kRayWidth_px = 0.5f;  // for the filter of the textures

void put(Image<float>& image, int y, int x, Colour value) {
  image.at(0, y, x) = value.x, image.at(1, y, x) = value.y, image.at(2, y, x) = value.z;
}

// Rays with equal keys see one smooth surface.
int surface_of(const Hit& hit) { return 8 * hit.object + hit.part; }

// Distance from the first hit to the farthest over their surface, metres; infinite where they are on several
// surfaces.
constexpr float kOverOutline = std::numeric_limits<float>::infinity();
float way_over(std::span<const Hit> hits) {
  float longest2 = 0;
  for (const Hit& hit : hits.subspan(1)) {
    if (surface_of(hit) != surface_of(hits[0])) return kOverOutline;
    const Vec3 way = hit.point - hits[0].point;
    longest2 = std::max(longest2, dot(way, way));
  }
  return std::sqrt(longest2);
}

}  // namespace

Renderer::Renderer(const Scene& scene, Lens lens, ShutterEffects shutter, int rows, int cols,
                   WorkerPool& pool, Sampling sampling)
    : scene_(scene),
      lens_(lens),
      shutter_(shutter),
      rows_(rows),
      cols_(cols),
      tile_rows_((rows + kTile - 1) / kTile),
      tile_cols_((cols + kTile - 1) / kTile),
      pool_(pool),
      sampling_(sampling),
      views_(kMostViews),
      reach_(scene.objects.size()),
      near_(tile_rows_, tile_cols_, static_cast<int>(scene.objects.size())),
      near_count_(1, tile_rows_, tile_cols_),
      tile_blur_(1, tile_rows_, tile_cols_),
      spread_blur_(1, tile_rows_, tile_cols_) {
  for (View& view : views_) view.pose_at(scene, 0);
}

void Renderer::pose_views(double begin_s, double end_s) {
  constexpr double kStep_s = 0.25e-3;  // half a pixel at 2000 px/s
  const double steps = scene_.moves() ? std::ceil((end_s - begin_s) / kStep_s) : 0;
  view_count_ = 1 + static_cast<int>(std::min<double>(steps, kMostViews - 1));
  first_s_ = begin_s;
  const double step_s = view_count_ > 1 ? (end_s - begin_s) / (view_count_ - 1) : 0;
  views_per_s_ = step_s > 0 ? 1 / step_s : 0;
  for (int i = 0; i < view_count_; ++i)
    views_[static_cast<std::size_t>(i)].pose_at(scene_, begin_s + i * step_s);
}

const View& Renderer::view_at(double time_s) const {
  if (view_count_ == 1) return views_[0];
  const double nearest = std::clamp<double>((time_s - first_s_) * views_per_s_, 0, view_count_ - 1) + 0.5;
  return views_[static_cast<std::size_t>(nearest)];
}

void Renderer::render(ExposureSpan span, Image<float>& light) {
  light.reshape(3, rows_, cols_);
  if (!shutter_.blur) span.begin_s = span.end_s = (span.begin_s + span.end_s) / 2;
  pose_views(span.begin_s, span.end_s + row_delay_s(rows_));
  find_near_objects();
  if (shutter_.blur && view_count_ > 1)
    measure_blur(span), spread_blur();
  else
    spread_blur_.fill(0);
  pool_.for_each(tile_rows_ * tile_cols_,
                 [&](int tile) { render_tile(span, tile / tile_cols_, tile % tile_cols_, light); });
}

void Renderer::find_near_objects() {
  const std::span<const View> views(views_.data(), static_cast<std::size_t>(view_count_));
  for (std::size_t i = 0; i < reach_.size(); ++i) {
    reach_[i] = views[0].bounds(static_cast<int>(i));
    for (const View& view : views) reach_[i].include(view.bounds(static_cast<int>(i)));
  }
  pool_.for_each(tile_rows_ * tile_cols_, [&](int tile) {
    const int tile_y = tile / tile_cols_, tile_x = tile % tile_cols_;
    // One more pixel on each side, because a distorted tile bulges.
    const auto corner = [&](int y, int x) {
      return lens_.ray_of(static_cast<float>(x), static_cast<float>(y));
    };
    const int y0 = tile_y * kTile - 1, x0 = tile_x * kTile - 1, y1 = y0 + kTile + 2, x1 = x0 + kTile + 2;
    const Vec2 first = corner(y0, x0);
    RayBox box{first.x, first.x, first.y, first.y};
    box.include(corner(y0, x1)), box.include(corner(y1, x0)), box.include(corner(y1, x1));
    std::uint8_t count = 0;
    for (std::size_t i = Scene::kDome + 1; i < reach_.size(); ++i)
      if (reach_[i].meets(box)) near_.row(tile_y, tile_x)[count++] = static_cast<std::uint8_t>(i);
    near_count_.at(0, tile_y, tile_x) = count;
  });
}

Renderer::Near Renderer::near(int tile_y, int tile_x) const {
  return {near_.row(tile_y, tile_x), near_count_.at(0, tile_y, tile_x)};
}

// How far the points of each tile travel through the picture during the exposure.
void Renderer::measure_blur(ExposureSpan span) {
  const float focal_px = static_cast<float>(lens_.intrinsics.fx_px);
  pool_.for_each(tile_rows_, [&](int tile_y) {
    std::fill_n(tile_blur_.row(0, tile_y), tile_cols_, 0.f);
    for (int y = tile_y * kTile; y < std::min(rows_, (tile_y + 1) * kTile); y += kProbe) {
      const double delay_s = row_delay_s(y);
      const View& middle = view_at((span.begin_s + span.end_s) / 2 + delay_s);
      const View& begin = view_at(span.begin_s + delay_s);
      const View& end = view_at(span.end_s + delay_s);
      for (int x = 0; x < cols_; x += kProbe) {
        const Hit hit = cast(middle, y, x, {0, 0}, near(tile_y, x / kTile));
        const Vec3 from = begin.project(hit.object, hit.point), to = end.project(hit.object, hit.point);
        float& most = tile_blur_.at(0, tile_y, x / kTile);
        most = std::max(most, focal_px * std::hypot(to.x - from.x, to.y - from.y));
      }
    }
  });
}

// A moving object blurs over its neighbours as far as it moves.
void Renderer::spread_blur() {
  spread_blur_.fill(0);
  for (int y = 0; y < tile_rows_; ++y)
    for (int x = 0; x < tile_cols_; ++x) {
      const float own = tile_blur_.at(0, y, x);
      if (own <= MotionBlur::kSharp_px) continue;
      const int reach = 1 + static_cast<int>(std::min(own, 1e4f)) / (2 * kTile);
      for (int v = std::max(0, y - reach); v <= std::min(tile_rows_ - 1, y + reach); ++v)
        for (int u = std::max(0, x - reach); u <= std::min(tile_cols_ - 1, x + reach); ++u)
          spread_blur_.at(0, v, u) = std::max(spread_blur_.at(0, v, u), own);
    }
}

void Renderer::render_tile(ExposureSpan span, int tile_y, int tile_x, Image<float>& light) const {
  const Near objects = near(tile_y, tile_x);
  const bool quick = sampling_ == Sampling::Quick, simple = objects.empty() || quick;
  const float blur_px = spread_blur_.at(0, tile_y, tile_x);
  const int along_motion = blur_px > 0 ? shutter_.blur->samples(blur_px) : 1;
  const int y1 = std::min(rows_, (tile_y + 1) * kTile), x1 = std::min(cols_, (tile_x + 1) * kTile);
  for (int y = tile_y * kTile; y < y1; ++y) {
    ExposureSpan row{span.begin_s + row_delay_s(y), span.end_s + row_delay_s(y)};
    if (along_motion == 1) row.begin_s = row.end_s = (row.begin_s + row.end_s) / 2;
    for (int x = tile_x * kTile; x < x1; ++x)
      put(light, y, x,
          simple ? mean_of_many(row, y, x, quick ? along_motion : std::max(along_motion, kRays), objects)
                 : mean_radiance(row, y, x, along_motion, objects));
  }
}

// place: in the pixel
Hit Renderer::cast(const View& view, int y, int x, Vec2 place, Near objects) const {
  return view.cast(lens_.ray_of(static_cast<float>(x) + place.x, static_cast<float>(y) + place.y), objects);
}

// The mean over the pixel and its exposure. along_motion: samples that the fastest object nearby needs.
Colour Renderer::mean_radiance(ExposureSpan row, int y, int x, int along_motion, Near objects) const {
  constexpr float kFour = 3;  // longest path, in pixels, for four samples
  const float pixel = 1 / static_cast<float>(lens_.intrinsics.fx_px);
  const auto time_s = [&](double fraction) { return row.begin_s + (row.end_s - row.begin_s) * fraction; };
  const auto ray = [&](double fraction, int place) {
    return cast(view_at(time_s(fraction)), y, x, samples_.place(place, kRays), objects);
  };
  const std::array<Hit, kRays> hits{ray(0.125, 0), ray(0.375, 1), ray(0.625, 2), ray(0.875, 3)};
  const View& middle = view_at(time_s(0.5));
  const auto sum_of_each = [&](const std::array<Hit, kRays>& each) {
    Colour sum;
    for (const Hit& hit : each) sum = sum + middle.radiance(hit, kRayWidth_px * pixel);
    return sum;
  };
  const float way = way_over(hits) / (pixel * hits[0].depth_m);
  const bool moves_far = along_motion > kRays;
  if (moves_far && way > kFour) return mean_of_many(row, y, x, along_motion, objects);
  if (way == kOverOutline) {
    const std::array<Hit, kRays> more{ray(0.125, 4), ray(0.375, 5), ray(0.625, 6), ray(0.875, 7)};
    return (sum_of_each(hits) + sum_of_each(more)) * (0.5f / kRays);
  }
  if (moves_far)  // a fast object may have passed between these rays
    for (const double fraction : {0.0, 0.25, 0.5, 0.75, 1.0})
      if (surface_of(ray(fraction, 0)) != surface_of(hits[0]))
        return mean_of_many(row, y, x, along_motion, objects);
  return sum_of_each(hits) * (1.f / kRays);
}

// The same from samples at even time steps. Where they meet more than one surface, they are doubled once.
Colour Renderer::mean_of_many(ExposureSpan row, int y, int x, int samples, Near objects) const {
  const float footprint = kRayWidth_px / static_cast<float>(lens_.intrinsics.fx_px);
  Colour sum;
  int first_surface = -1;
  bool outline = false;
  int taken = 0;
  for (; taken < (outline ? 2 : 1) * samples; ++taken) {
    const int k = taken % samples;  // the second half has other positions at the same instants
    const View& view = view_at(row.begin_s + (row.end_s - row.begin_s) * MotionBlur::fraction(k, samples));
    const Hit hit = cast(view, y, x, samples_.place(taken, samples), objects);
    sum = sum + view.radiance(hit, footprint);
    if (taken == 0) first_surface = surface_of(hit);
    outline |= surface_of(hit) != first_surface;
  }
  return sum * (1 / static_cast<float>(taken));
}

}  // namespace hdrcam
