#include "render/views/view_renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "render/views/cubic_between_pixels.h"
#include "render/views/pixel_area.h"

namespace hdrcam {
namespace {

// What one source shows at a pixel of the view, and how much it counts.
struct Sight {
  const Keyframe* key;
  float x, y, inverse_depth, rank, weight;
  float side_px;  // of the square of the source's pixels that a pixel of the view covers
};

struct Sights {
  std::array<Sight, 2> of{};
  std::size_t count = 0;

  void keep_only(std::size_t which) { of[0] = of[which], count = 1; }
};

constexpr float kLeastWeight = 1e-3f;  // of a frame that is only needed where the other shows nothing

// Leaves out what the other sight replaces: a frame that does not count at this moment only fills what the
// other does not show, and the nearer of two surfaces covers the farther one.
void leave_out_hidden(Sights& sights) {
  constexpr float kSameSurface = 0.3f;  // of rank: beyond it the nearer one covers the other
  auto& of = sights.of;
  if (sights.count == 2 && of[0].weight < kLeastWeight) sights.keep_only(1);
  if (sights.count == 2 && of[1].weight < kLeastWeight) sights.keep_only(0);
  if (sights.count < 2) return;
  if (of[0].rank > of[1].rank + kSameSurface)
    sights.keep_only(0);
  else if (of[1].rank > of[0].rank + kSameSurface)
    sights.keep_only(1);
}

// What one source shows there: its picture between its pixels, or, where the view reduces it, the mean over
// the pixels that one of the view covers. The provenance is that of the nearest pixel.
struct Shown {
  float radiance[3], sigma;
  std::uint8_t provenance;
};

Shown shown_by(const Sight& sight) {
  constexpr float kReduced_px = 1.25f;  // fine texture hardly aliases below it, and stays sharp
  const HdrFrame& seen = sight.key->frame;
  const CubicBetweenPixels at(seen.radiance, sight.x, sight.y);
  const std::uint8_t provenance = seen.provenance.at(0, at.nearest_row(), at.nearest_col());
  if (sight.side_px > kReduced_px) {
    const PixelArea area(sight.x, sight.y, sight.side_px, seen.radiance.rows(), seen.radiance.cols());
    return {{area.mean(seen.radiance, 0), area.mean(seen.radiance, 1), area.mean(seen.radiance, 2)},
            area.mean(seen.sigma, 0),
            provenance};
  }
  return {{at.value(0), at.value(1), at.value(2)},
          seen.sigma.at(0, at.nearest_row(), at.nearest_col()),
          provenance};
}

// The mean of the sights at a pixel of the view; its provenance is that of the one that counts most.
void show(Sights& sights, int y, int x, HdrFrame& frame) {
  const std::size_t count = sights.count;
  auto& of = sights.of;
  float sum = 0;
  for (std::size_t i = 0; i < count; ++i) sum += of[i].weight = std::max(of[i].weight, kLeastWeight);
  const std::size_t most = count == 2 && of[1].weight > of[0].weight ? 1 : 0;
  float radiance[3] = {0, 0, 0}, sigma = 0, inverse_depth = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Sight& sight = of[i];
    const Shown shown = shown_by(sight);
    const float weight = sight.weight / sum;
    for (int c = 0; c < 3; ++c) radiance[c] += weight * shown.radiance[c];
    inverse_depth += weight * sight.inverse_depth;
    sigma += weight * shown.sigma;
    if (i == most) frame.provenance.at(0, y, x) = shown.provenance;
  }
  for (int c = 0; c < 3; ++c) frame.radiance.at(c, y, x) = std::max(0.f, radiance[c]);
  frame.depth.at(0, y, x) = 1 / inverse_depth;
  frame.sigma.at(0, y, x) = sigma;
}

}  // namespace

void ViewRenderer::render(const KeyframeInterval& interval, const SceneView& view, const SnapshotHold& field,
                          HdrFrame& frame) {
  HDRCAM_CHECK(interval.before != nullptr || interval.after != nullptr);
  static const FlowField kNoMotion;
  const RigidTransform T_view_recorded = view.T_world_camera.inverse() * interval.T_world_camera();
  const auto share = static_cast<float>(interval.share);
  sources_[0].key = interval.before, sources_[1].key = interval.after;
  if (interval.before != nullptr)
    draw(interval.after != nullptr ? interval.after->from_previous : kNoMotion, share, T_view_recorded, view,
         sources_[0]);
  if (interval.after != nullptr)
    draw(interval.before != nullptr ? interval.after->to_previous : kNoMotion, 1 - share, T_view_recorded,
         view, sources_[1]);
  frame.radiance.reshape(3, view.rows, view.cols);
  for (Image<float>* plane : {&frame.sigma, &frame.depth}) plane->reshape(1, view.rows, view.cols);
  frame.provenance.reshape(1, view.rows, view.cols);
  for (Image<float>* flow : {&frame.flow, &frame.flow_forward, &frame.field_flow, &frame.field_flow_forward})
    flow->reshape(0, 0, 0);
  frame.points.clear();
  frame.white = interval.nearest().frame.white;
  blend(interval, frame);
  SceneView place = view;
  place.time_s = interval.time_s();
  fill(place, field, interval.nearest().depth_unit, frame);
  const bool knows_depth = interval.lies_between()
                               ? interval.before->knows_depth && interval.after->knows_depth
                               : interval.nearest().knows_depth;
  if (!knows_depth) frame.depth.reshape(0, 0, 0);
}

// A source's pixels where the view sees them: `share` of the way along their motion, then along their depth.
void ViewRenderer::draw(const FlowField& toward, float share, const RigidTransform& T_view_recorded,
                        const SceneView& view, Source& source) {
  constexpr float kTie = 0.15f;  // of ln depth: surfaces closer than this are ordered by their motion's trust
  constexpr float kNearest = 1e-3f;  // z over the source's: nearer, or behind the view, nothing is drawn
  const Keyframe& key = *source.key;
  const int rows = key.inverse_depth.rows(), cols = key.inverse_depth.cols();
  source.vertices.reshape(rows, cols);
  MeshVertices& out = source.vertices;
  const auto scale = static_cast<float>(view.lens.fx_px / key.lens.fx_px);
  const Eigen::Matrix3f R = T_view_recorded.R.cast<float>();
  const Eigen::Vector3f t = T_view_recorded.t.cast<float>();
  const auto fx = static_cast<float>(key.lens.fx_px), fy = static_cast<float>(key.lens.fy_px);
  const auto cx = static_cast<float>(key.lens.cx_px), cy = static_cast<float>(key.lens.cy_px);
  const bool moves = share > 0 && !toward.empty();
  pool_.for_rows(rows + 2, [&](int r0, int r1) {
    for (int row = r0; row < r1; ++row)
      for (int col = 0; col < cols + 2; ++col) {
        const int y = std::clamp(row - 1, 0, rows - 1), x = std::clamp(col - 1, 0, cols - 1);
        float px = MeshVertices::source(col, cols), py = MeshVertices::source(row, rows), trust = 1;
        if (moves) {
          px += share * toward.vectors.at(0, y, x), py += share * toward.vectors.at(1, y, x);
          trust = toward.confidence.at(0, y, x);
        }
        const float q = key.inverse_depth.at(0, y, x);
        const Eigen::Vector3f seen = R * Eigen::Vector3f((px - cx) / fx, (py - cy) / fy, 1) + t * q;
        const float z = std::max(seen.z(), kNearest);
        out.place.at(0, row, col) =
            static_cast<float>(view.lens.fx_px) * seen.x() / z + static_cast<float>(view.lens.cx_px);
        out.place.at(1, row, col) =
            static_cast<float>(view.lens.fy_px) * seen.y() / z + static_cast<float>(view.lens.cy_px);
        out.inverse.at(0, row, col) = seen.z() > kNearest ? q / z : 0;
        out.rank.at(0, row, col) = std::log(q / z) + kTie * trust;
        out.size.at(0, row, col) = scale / z;
      }
  });
  draw_mesh(out, view.rows, view.cols, pool_, source.answer);
}

void ViewRenderer::blend(const KeyframeInterval& interval, HdrFrame& frame) {
  const float shares[2] = {1 - static_cast<float>(interval.share), static_cast<float>(interval.share)};
  const int rows = frame.radiance.rows(), cols = frame.radiance.cols();
  const auto sights_at = [&](int y, int x) {
    Sights sights;
    for (std::size_t i = 0; i < 2; ++i) {
      const Source& source = sources_[i];
      if (source.key == nullptr || !(source.answer.inverse.at(0, y, x) > 0)) continue;
      sights.of[sights.count++] = {source.key,
                                   source.answer.source.at(0, y, x),
                                   source.answer.source.at(1, y, x),
                                   source.answer.inverse.at(0, y, x),
                                   source.answer.rank.at(0, y, x),
                                   shares[i],
                                   1 / source.answer.size.at(0, y, x)};
    }
    return sights;
  };
  holes_.reshape(1, rows, cols);
  pool_.for_rows(rows, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y)
      for (int x = 0; x < cols; ++x) {
        Sights sights = sights_at(y, x);
        holes_.at(0, y, x) = sights.count == 0;
        if (sights.count == 0) continue;
        leave_out_hidden(sights);
        show(sights, y, x, frame);
      }
  });
}

void ViewRenderer::fill(const SceneView& view, const SnapshotHold& field, float depth_unit, HdrFrame& frame) {
  constexpr float kFieldSigma = 1;  // of ln radiance: nobody saw it
  if (std::ranges::none_of(holes_.samples(), [](std::uint8_t hole) { return hole != 0; })) return;
  if (field) {
    SceneView wanted = view;
    wanted.wanted = &holes_;
    field->look(wanted, pool_, picture_);
  }
  for (std::size_t i = 0; i < holes_.size(); ++i) {
    if (holes_.samples()[i] == 0) continue;
    for (int c = 0; c < 3; ++c) frame.radiance.plane(c)[i] = field ? picture_.radiance.plane(c)[i] : 0;
    frame.depth.samples()[i] = field ? picture_.depth.samples()[i] * depth_unit : 0;
    frame.sigma.samples()[i] = kFieldSigma;
    frame.provenance.samples()[i] = static_cast<std::uint8_t>(Provenance::Field);
  }
}

}  // namespace hdrcam
