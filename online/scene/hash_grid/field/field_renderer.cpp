#include "online/scene/hash_grid/field/field_renderer.h"

#include <spdlog/spdlog.h>

#include <cmath>
#include <utility>

#include "online/scene/hash_grid/field/vulkan/vulkan_probe.h"

namespace hdrcam {
namespace {

constexpr int kStripes = 8;  // units of work, each with a probe; enough for the usual numbers of threads
constexpr float kFarthest = 0.02f;  // inverse depth of what a whole row does not show
constexpr float kAtRest_px = 0.5f;  // what moves less than this between two frames
constexpr float kBehind = 1.2f;  // times the inverse depth beside a hole, at most, is that of what is in it
constexpr int kHole = 2;         // tiles without a surface; fewer are gaps between the pixels of one

// The nearest frame and the distance to it in frame intervals.
ProbeView probe_view(const WindowFrames& window, const RigidTransform& T_world_camera, double time_s) {
  ProbeView view;
  view.T_anchor_camera = window.T_anchor_camera(T_world_camera);
  view.frame = window.nearest(time_s);
  const double away = time_s - window.frame(view.frame).time_s;
  const int other = view.frame + (away > 0 ? 1 : -1);
  if (other < 0 || other >= window.size()) return view;
  const double interval = std::abs(window.frame(other).time_s - window.frame(view.frame).time_s);
  if (interval > 0 && std::abs(away) > 1e-3 * interval)
    view.offset = static_cast<float>(std::clamp(away / interval, -0.5, 0.5));
  return view;
}

// Pixels of a view in those of the window's camera: the same ray. window px = scale * (x + 0.5) + shift.
struct PixelMap {
  float scale[2], shift[2];

  PixelMap(const Intrinsics& camera, const Intrinsics& lens) {
    const double sx = camera.fx_px / lens.fx_px, sy = camera.fy_px / lens.fy_px;
    scale[0] = static_cast<float>(sx), scale[1] = static_cast<float>(sy);
    shift[0] = static_cast<float>(camera.cx_px - sx * lens.cx_px);
    shift[1] = static_cast<float>(camera.cy_px - sy * lens.cy_px);
  }
  float map(int axis, int pixel) const {
    return (static_cast<float>(pixel) + 0.5f) * scale[axis] + shift[axis];
  }
};

// What a picture may hold, whatever the fit has done: finite, not negative.
float presentable(float value) {
  constexpr float kMost = 1e9f;
  return std::isfinite(value) ? std::clamp(value, 0.f, kMost) : 0.f;
}

void reshape(FieldPicture& picture, int rows, int cols) {
  picture.radiance.reshape(3, rows, cols);
  for (Image<float>* plane : {&picture.depth, &picture.confidence}) plane->reshape(1, rows, cols);
  for (Image<float>& flow : picture.flow) flow.reshape(2, rows, cols);
}

void clear(FieldPicture& picture) {
  for (Image<float>* plane :
       {&picture.radiance, &picture.depth, &picture.confidence, &picture.flow[0], &picture.flow[1]})
    plane->fill(0);
}

// flow_scale: pixels of the window's camera in one of the picture, by axis.
void store(const ProbeAnswer& answer, const float* flow_scale, int y, int x, FieldPicture& picture) {
  for (int c = 0; c < 3; ++c) picture.radiance.at(c, y, x) = presentable(answer.radiance[c]);
  constexpr float kNear = 1, kFar = 1e-4f;  // inverse depths, of the near plane and of what is no farther
  picture.depth.at(0, y, x) =
      1 / std::clamp(std::isfinite(answer.inverse_depth) ? answer.inverse_depth : kNear, kFar, kNear);
  picture.confidence.at(0, y, x) = std::clamp(presentable(answer.confidence), 0.f, 1.f);
  for (std::size_t n = 0; n < 2; ++n)
    for (int a = 0; a < 2; ++a)
      picture.flow[n].at(a, y, x) =
          std::isfinite(answer.flow[n][a]) ? answer.flow[n][a] / flow_scale[a] : 0.f;
}

// Whether a frame's neighbours show what it sees in a pixel where the poses say.
bool is_at_rest(const BasePixel& base) {
  return std::all_of(base.begin() + kBaseFlow, base.begin() + kBaseConfidence,
                     [](float px) { return std::abs(px) < kAtRest_px; });
}

}  // namespace

FieldRenderer::FieldRenderer(GpuDevice* gpu) {
  if (gpu == nullptr) return;
  auto probe = VulkanProbe::make(*gpu);
  if (probe)
    gpu_probe_ = std::move(*probe);
  else
    fall_back_to_cpu(probe.error());
}

FieldRenderer::~FieldRenderer() = default;

// The surface of a frame in another view: each of its pixels is projected into the view, and nearer ones
// win.
void FieldRenderer::splat_surface(const WindowFrustum& frustum, const WindowFrame& frame,
                                  const ProbeView& from, Image<Tile>& tiles) {
  tiles.reshape(1, (frustum.rows + kSplat - 1) / kSplat, (frustum.cols + kSplat - 1) / kSplat);
  tiles.fill({});
  const auto rows = static_cast<float>(tiles.rows()), cols = static_cast<float>(tiles.cols());
  const ViewGeometry<float> here(frustum, frame.T_anchor_camera), there(frustum, from.T_anchor_camera);
  for (int y = 0; y < frustum.rows; ++y)
    for (int x = 0; x < frustum.cols; ++x) {
      const BasePixel& base = frame.base.at(0, y, x);
      const float centre[2] = {static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f};
      float point[3], seen[3];
      here.place(centre, base[kBaseSurface], point);
      there.project(point, seen, nullptr);
      const float column = seen[0] / kSplat, row = seen[1] / kSplat;
      if (!(column >= 0 && row >= 0 && column < cols && row < rows)) continue;
      Tile& tile = tiles.at(0, static_cast<int>(row), static_cast<int>(column));
      if (seen[2] > tile.inverse_depth) tile.inverse_depth = seen[2], tile.at_rest = is_at_rest(base);
    }
}

// Who shows what in the view: the frame nearest in time. What it does not show since something is before it
// another frame may, if that is at rest; the rest of it continues what is beside it.
void FieldRenderer::find_sources(const RadianceField& field, const ProbeView& from) {
  const WindowFrames& window = field.window;
  splat_surface(window.frustum(), window.frame(from.frame), from, tiles_);
  guide_.reshape(1, tiles_.rows(), tiles_.cols());
  sources_.reshape(1, tiles_.rows(), tiles_.cols());
  bool holes = false;
  for (int y = 0; y < guide_.rows(); ++y) holes |= find_holes(from.frame, y);
  if (!holes) return;
  for (int away = 1; away < window.size(); ++away)
    for (const int frame : {from.frame - away, from.frame + away})
      if (frame >= 0 && frame < window.size()) show_background(window, frame, from);
  for (int y = 0; y < guide_.rows(); ++y) continue_background(y);
}

// In a row of the nearest frame's tiles: what lies between two surfaces is as far as the farther one, which
// the nearer one hides. Outside the frame's picture, and in gaps between the pixels of a surface, the frame
// is asked all the same. Returns whether there are holes.
bool FieldRenderer::find_holes(int nearest, int y) {
  const int cols = guide_.cols();
  const Tile* tiles = tiles_.row(0, y);
  const auto surface = [&](int x) { return x >= 0 && x < cols ? tiles[x].inverse_depth : 1; };
  bool holes = false;
  for (int x = 0, end = 0; x < cols; x = end) {
    end = x + 1;
    guide_.at(0, y, x) = surface(x);
    sources_.at(0, y, x) = {.frame = nearest, .column = x};
    if (surface(x) >= 0) continue;
    while (end < cols && surface(end) < 0) ++end;
    const bool none = x == 0 && end == cols, hole = x > 0 && end < cols && end - x >= kHole;
    const float behind = none ? kFarthest : std::min(surface(x - 1), surface(end));
    for (int k = x; k < end; ++k) {
      guide_.at(0, y, k) = behind;
      sources_.at(0, y, k) = {.frame = hole ? kNoFrame : nearest, .column = k};
    }
    holes |= hole;
  }
  return holes;
}

// In holes, what a frame shows at rest that is no nearer than what is beside them.
void FieldRenderer::show_background(const WindowFrames& window, int frame, const ProbeView& from) {
  splat_surface(window.frustum(), window.frame(frame), from, tiles_);
  for (std::size_t i = 0; i < guide_.size(); ++i) {
    const Tile& tile = tiles_.samples()[i];
    if (sources_.samples()[i].frame != kNoFrame || !tile.at_rest ||
        tile.inverse_depth > kBehind * guide_.samples()[i])
      continue;
    sources_.samples()[i].frame = frame;
    guide_.samples()[i] = tile.inverse_depth;
  }
}

// In a row, of what no frame shows: the farther of both sides, past its edge, whose pixels have a share of
// what is before it.
void FieldRenderer::continue_background(int y) {
  const int cols = guide_.cols();
  const float* guide = guide_.row(0, y);
  Source* sources = sources_.row(0, y);
  const auto shown = [&](int x) { return x >= 0 && x < cols && sources[x].frame != kNoFrame; };
  for (int x = 0, end = 0; x < cols; x = end) {
    end = x + 1;
    if (shown(x)) continue;
    while (!shown(end)) ++end;  // a hole is between two surfaces
    const int way = guide[x - 1] <= guide[end] ? -1 : 1, edge = way < 0 ? x - 1 : end;
    const int beside = shown(edge + way) ? edge + way : edge;
    std::fill(sources + x, sources + end, sources[beside]);
  }
}

void FieldRenderer::render(const RadianceField& field, const SceneView& view, WorkerPool& pool,
                           FieldPicture& picture) {
  HDRCAM_CHECK(field.window.size() > 0 && view.rows > 0 && view.cols > 0);
  HDRCAM_CHECK(view.lens.fx_px > 0 && view.lens.fy_px > 0);
  if (!(view.exposure_s > 0)) {
    render_instant(field, view, view.time_s, pool, picture);
    return;
  }
  // the centre last, so that everything but the radiance belongs to it
  constexpr int kOrder[kInstants] = {0, 1, 3, 4, 2};
  for (const int i : kOrder) {
    render_instant(field, view, view.time_s + view.exposure_s * ((i + 0.5) / kInstants - 0.5), pool, picture);
    if (i == 0) sum_.reshape_like(picture.radiance), sum_.fill(0);
    for (std::size_t p = 0; p < sum_.size(); ++p) sum_.samples()[p] += picture.radiance.samples()[p];
  }
  for (std::size_t p = 0; p < sum_.size(); ++p)
    picture.radiance.samples()[p] = sum_.samples()[p] / static_cast<float>(kInstants);
}

void FieldRenderer::render_instant(const RadianceField& field, const SceneView& view, double time_s,
                                   WorkerPool& pool, FieldPicture& picture) {
  reshape(picture, view.rows, view.cols);
  const ProbeView from = probe_view(field.window, view.T_world_camera, time_s);
  const PixelMap map(field.window.frustum().camera, view.lens);
  if (view.wanted != nullptr) {
    HDRCAM_CHECK(view.wanted->rows() == view.rows && view.wanted->cols() == view.cols);
    clear(picture);
  }
  aim_rays(field, from, view);
  answers_.resize(rays_.size());
  if (rays_.empty()) return;
  look(field, from, pool);
  pool.for_rows(static_cast<int>(answers_.size()), [&](int first, int last) {
    for (auto i = static_cast<std::size_t>(first); i < static_cast<std::size_t>(last); ++i)
      store(answers_[i], map.scale, pixels_[i].y, pixels_[i].x, picture);
  });
}

// One for each pixel that is wanted, guided by the surface that is seen there; those of one frame follow each
// other.
void FieldRenderer::aim_rays(const RadianceField& field, const ProbeView& from, const SceneView& view) {
  const WindowFrame& frame = field.window.frame(from.frame);
  const PixelMap map(field.window.frustum().camera, view.lens);
  const bool own = from.T_anchor_camera == frame.T_anchor_camera;  // then a ray's surface is its pixel's
  if (!own) find_sources(field, from);
  const auto aim = [&](int row, int column) {
    const float px = map.map(0, column), py = map.map(1, row);
    if (own) {
      const int x = std::clamp(static_cast<int>(px), 0, frame.base.cols() - 1);
      const int y = std::clamp(static_cast<int>(py), 0, frame.base.rows() - 1);
      return Aim{from.frame, {{px, py}, frame.base.at(0, y, x)[kBaseSurface]}};
    }
    const int gx = std::clamp(static_cast<int>(px) / kSplat, 0, guide_.cols() - 1);
    const int gy = std::clamp(static_cast<int>(py) / kSplat, 0, guide_.rows() - 1);
    const Source& source = sources_.at(0, gy, gx);
    const float beside = (static_cast<float>(source.column) + 0.5f) * kSplat;
    return Aim{source.frame, {{source.column == gx ? px : beside, py}, guide_.at(0, gy, gx)}};
  };
  const auto for_wanted = [&](auto&& body) {
    for (int y = 0; y < view.rows; ++y)
      for (int x = 0; x < view.cols; ++x)
        if (view.wanted == nullptr || view.wanted->at(0, y, x) != 0) body(y, x, aim(y, x));
  };
  ends_.assign(static_cast<std::size_t>(field.window.size()), 0);
  for_wanted([&](int, int, const Aim& aimed) { ++ends_[static_cast<std::size_t>(aimed.frame)]; });
  std::size_t rays = 0;
  for (std::size_t& end : ends_) rays += std::exchange(end, rays);  // where the rays of a frame begin..
  rays_.resize(rays), pixels_.resize(rays);
  for_wanted([&](int y, int x, const Aim& aimed) {
    std::size_t& end = ends_[static_cast<std::size_t>(aimed.frame)];  // ..and, once all are there, end
    rays_[end] = aimed.ray, pixels_[end++] = {y, x};
  });
}

// Along all rays of the view.
void FieldRenderer::look(const RadianceField& field, const ProbeView& from, WorkerPool& pool) {
  std::size_t begin = 0;
  for (int frame = 0; frame < field.window.size(); ++frame) {
    const std::size_t end = ends_[static_cast<std::size_t>(frame)], count = end - begin;
    const ProbeView of_frame{from.T_anchor_camera, frame, frame == from.frame ? from.offset : 0};
    if (count > 0)
      look(field, of_frame, {rays_.data() + begin, count}, {answers_.data() + begin, count}, pool);
    begin = end;
  }
}

void FieldRenderer::look(const RadianceField& field, const ProbeView& from, std::span<const ProbeRay> rays,
                         std::span<ProbeAnswer> answers, WorkerPool& pool) {
  if (gpu_probe_ != nullptr) {
    const Result<void> looked = gpu_probe_->look(field, from, rays, answers);
    if (looked) return;
    fall_back_to_cpu(looked.error());
  }
  while (probes_.size() < kStripes) probes_.emplace_back(field.networks, kMaxSamples);
  const std::size_t batches = (rays.size() + FieldProbe::kRays - 1) / FieldProbe::kRays;
  pool.for_each(kStripes, [&](int stripe) {
    const auto own = static_cast<std::size_t>(stripe);
    for (std::size_t batch = own; batch < batches; batch += kStripes) {
      const std::size_t first = batch * FieldProbe::kRays;
      const std::size_t n = std::min<std::size_t>(FieldProbe::kRays, rays.size() - first);
      probes_[own].look(field, from, rays.subspan(first, n), answers.subspan(first, n));
    }
  });
}

void FieldRenderer::fall_back_to_cpu(const Error& why) {
  spdlog::warn("views of the field go on with the processor: {}", why.message);
  gpu_probe_.reset();
}

}  // namespace hdrcam
