#include "online/scene/hash_grid/field/field_probe.h"

#include "online/scene/hash_grid/field/ray_sampler.h"

namespace hdrcam {
namespace {

using View = ViewGeometry<float>;

// The base where a frame sees a window point; unknown outside its picture. Returns the density prior there.
float base_at(const View& frame_view, const WindowFrame& frame, const float* point, float* base) {
  float pixel[3];
  frame_view.project(point, pixel, nullptr);
  fetch_base(frame.base, pixel, base, static_cast<float*>(nullptr), static_cast<float*>(nullptr));
  const bool outside = pixel[0] < -0.5f || pixel[1] < -0.5f ||
                       pixel[0] > static_cast<float>(frame.base.cols()) + 0.5f ||
                       pixel[1] > static_cast<float>(frame.base.rows()) + 0.5f;
  if (outside)
    for (int c = 0; c < 3; ++c) base[kBaseGate + c] = 1;
  return surface_prior(pixel[2], base[kBaseSurface]).log_density;
}

}  // namespace

FieldProbe::FieldProbe(const FieldNetworks<float>& networks, int most_samples) {
  const int ld = (kRays * most_samples + kSampleMultiple - 1) / kSampleMultiple * kSampleMultiple;
  static_.reserve(networks.static_, ld);
  dynamic_.reserve(networks.dynamic, ld);
  ray_.resize(kRays);
}

void FieldProbe::look(const RadianceField& field, const ProbeView& view, std::span<const ProbeRay> rays,
                      std::span<ProbeAnswer> answers) {
  HDRCAM_CHECK(rays.size() <= kRays && answers.size() == rays.size());
  place(field, view, rays);
  static_.forward(field.networks.static_);
  if (field.has_dynamic) {
    dynamic_.forward(field.networks.dynamic);
    if (view.offset != 0) {
      move_to_frame(field, view, static_cast<int>(rays.size()));
      dynamic_.forward(field.networks.dynamic);
    }
  }
  for (std::size_t r = 0; r < rays.size(); ++r)
    answers[r] = answer(field, view, rays[r], static_cast<int>(r));
}

void FieldProbe::place(const RadianceField& field, const ProbeView& view, std::span<const ProbeRay> rays) {
  const View camera(field.window.frustum(), view.T_anchor_camera);
  const int count = field.samples_per_ray, slot = field.window.frame(view.frame).slot;
  const int used = static_cast<int>(rays.size()) * count;
  static_.n = dynamic_.n = (used + kSampleMultiple - 1) / kSampleMultiple * kSampleMultiple;
  std::fill(dynamic_.slot.begin(), dynamic_.slot.end(), slot);
  for (std::size_t r = 0; r < rays.size(); ++r) {
    RaySamples<float>& ray = ray_[r];
    ray.count = count;
    ray.has_dynamic = field.has_dynamic;
    place_samples(
        rays[r].guide, count, [] { return 0.5f; }, ray.inverse_depth, ray.spacing);
    for (int k = 0; k < count; ++k) {
      const int s = static_cast<int>(r) * count + k;
      camera.place(rays[r].pixel, ray.inverse_depth[k], ray.position[k]);
      for (int a = 0; a < 3; ++a)
        static_.position.plane(a)[s] = dynamic_.position.plane(a)[s] = ray.position[k][a];
    }
  }
}

// One fixed-point iteration of x_frame = x - offset * flow(x_frame), from x.
void FieldProbe::move_to_frame(const RadianceField& field, const ProbeView& view, int rays) {
  const WindowFrustum& frustum = field.window.frustum();
  const WindowFrame& frame = field.window.frame(view.frame);
  const View frame_view(frustum, frame.T_anchor_camera);
  const float unit[3] = {static_cast<float>(frustum.u_per_px()), static_cast<float>(frustum.v_per_px()),
                         static_cast<float>(WindowFrustum::kDepthUnit)};
  const int n = view.offset > 0 ? 0 : 1;
  for (int r = 0; r < rays; ++r)
    for (int k = 0; k < ray_[static_cast<std::size_t>(r)].count; ++k) {
      const int s = r * ray_[static_cast<std::size_t>(r)].count + k;
      const float* point = ray_[static_cast<std::size_t>(r)].position[k];
      float base[kBaseChannels];
      const float prior = base_at(frame_view, frame, point, base);
      const auto sample = decode_dynamic(dynamic_.raw, s, base, prior);
      for (int a = 0; a < 3; ++a)
        dynamic_.position.plane(a)[s] = point[a] - std::abs(view.offset) * sample.flow[n][a] * unit[a];
    }
}

ProbeAnswer FieldProbe::answer(const RadianceField& field, const ProbeView& view, const ProbeRay& probe,
                               int r) {
  const WindowFrames& window = field.window;
  const WindowFrustum& frustum = window.frustum();
  const WindowFrame& frame = window.frame(view.frame);
  const View frame_view(frustum, frame.T_anchor_camera);
  const View neighbour_view[2] = {
      View(frustum, view.frame + 1 < window.size() ? window.frame(view.frame + 1).T_anchor_camera
                                                   : view.T_anchor_camera),
      View(frustum, view.frame > 0 ? window.frame(view.frame - 1).T_anchor_camera : view.T_anchor_camera)};
  const float unit[3] = {static_cast<float>(frustum.u_per_px()), static_cast<float>(frustum.v_per_px()),
                         static_cast<float>(WindowFrustum::kDepthUnit)};
  RaySamples<float>& ray = ray_[static_cast<std::size_t>(r)];
  float known[2][kMaxSamples];  // 1 - gate of the static and dynamic sample
  for (int k = 0; k < ray.count; ++k) {
    const int s = r * ray.count + k;
    float base[kBaseChannels];
    float prior = base_at(frame_view, frame, ray.position[k], base);
    ray.static_[k] = decode_static(static_.raw, s, base, prior);
    known[0][k] = 1 - (base[kBaseGate] + base[kBaseGate + 1] + base[kBaseGate + 2]) / 3;
    if (!ray.has_dynamic) continue;
    if (view.offset != 0) {
      const float point[3] = {dynamic_.position.plane(0)[s], dynamic_.position.plane(1)[s],
                              dynamic_.position.plane(2)[s]};
      prior = base_at(frame_view, frame, point, base);
    }
    ray.dynamic[k] = decode_dynamic(dynamic_.raw, s, base, prior);
    known[1][k] = 1 - (base[kBaseGate] + base[kBaseGate + 1] + base[kBaseGate + 2]) / 3;
  }
  RayTrace<float> trace;
  const RayPicture<float> picture = render_ray(ray, field.networks.blend, trace);
  ProbeAnswer answer{{picture.radiance[0], picture.radiance[1], picture.radiance[2]},
                     picture.inverse_depth,
                     picture.share,
                     0,
                     {{0, 0}, {0, 0}}};
  for (int k = 0; k < ray.count; ++k) {
    const float dynamic_weight = trace.combined.weight[k] * trace.combined.share[k];
    const float static_weight = trace.combined.weight[k] - dynamic_weight;
    answer.confidence += static_weight * known[0][k] + (ray.has_dynamic ? dynamic_weight * known[1][k] : 0);
    for (int n = 0; n < 2; ++n) {
      float landing[3];
      neighbour_view[n].project(ray.position[k], landing, nullptr);
      for (int a = 0; a < 2; ++a) answer.flow[n][a] += static_weight * (landing[a] - probe.pixel[a]);
      if (!ray.has_dynamic) continue;
      const int s = r * ray.count + k;
      float point[3];
      for (int a = 0; a < 3; ++a)
        point[a] = dynamic_.position.plane(a)[s] + ray.dynamic[k].flow[n][a] * unit[a];
      neighbour_view[n].project(point, landing, nullptr);
      for (int a = 0; a < 2; ++a) answer.flow[n][a] += dynamic_weight * (landing[a] - probe.pixel[a]);
    }
  }
  return answer;
}

}  // namespace hdrcam
