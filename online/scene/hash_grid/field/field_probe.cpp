#include "online/scene/hash_grid/field/field_probe.h"

#include "online/scene/hash_grid/field/ray_sampler.h"

namespace hdrcam {
namespace {

using View = ViewGeometry<float>;

}  // namespace

// What all rays of a batch are seen with: the nearest frame, its camera and those of its neighbours, by
// Neighbour (the view's own where there is none).
struct FieldProbe::Cameras {
  const WindowFrame& frame;
  View of_frame, of_neighbour[2];
  float flow_unit[3];  // window units per unit of flow

  Cameras(const WindowFrames& window, const ProbeView& view)
      : frame(window.frame(view.frame)),
        of_frame(window.frustum(), frame.T_anchor_camera),
        of_neighbour{View(window.frustum(), view.frame + 1 < window.size()
                                                ? window.frame(view.frame + 1).T_anchor_camera
                                                : view.T_anchor_camera),
                     View(window.frustum(), view.frame > 0 ? window.frame(view.frame - 1).T_anchor_camera
                                                           : view.T_anchor_camera)},
        flow_unit{} {
    flow_units(window.frustum(), flow_unit);
  }

  // The base where the frame sees a window point; unknown outside its picture. Returns the density prior
  // there.
  float base_at(const float* point, float* base) const {
    float pixel[3];
    of_frame.project(point, pixel, nullptr);
    fetch_base(frame.base, pixel, base);
    const bool outside = pixel[0] < -0.5f || pixel[1] < -0.5f ||
                         pixel[0] > static_cast<float>(frame.base.cols()) + 0.5f ||
                         pixel[1] > static_cast<float>(frame.base.rows()) + 0.5f;
    if (outside)
      for (int c = 0; c < 3; ++c) base[kBaseGate + c] = 1;
    return surface_prior(pixel[2], base[kBaseSurface]).log_density;
  }
};

// The state's share of the radiance of a ray's samples, against the networks'.
struct FieldProbe::StateShares {
  float of_static[kMaxSamples], of_dynamic[kMaxSamples];
};

FieldProbe::FieldProbe(const FieldNetworks<float>& networks, int most_samples) {
  const int ld = whole_runs(kRays * most_samples);
  static_.reserve(networks.static_, ld);
  dynamic_.reserve(networks.dynamic, ld);
  ray_.resize(kRays);
}

void FieldProbe::look(const RadianceField& field, const ProbeView& view, std::span<const ProbeRay> rays,
                      std::span<ProbeAnswer> answers) {
  HDRCAM_CHECK(rays.size() <= kRays && answers.size() == rays.size());
  const Cameras cameras(field.window, view);
  place(field, view, rays);
  static_.forward(field.networks.static_);
  if (field.has_dynamic) {
    dynamic_.forward(field.networks.dynamic);
    if (view.offset != 0) {
      move_to_frame(cameras, view, static_cast<int>(rays.size()));
      dynamic_.forward(field.networks.dynamic);
    }
  }
  for (std::size_t r = 0; r < rays.size(); ++r) {
    StateShares known;
    decode(cameras, view, static_cast<int>(r), known);
    answers[r] = answer(cameras, field.networks.blend, rays[r], static_cast<int>(r), known);
  }
}

void FieldProbe::place(const RadianceField& field, const ProbeView& view, std::span<const ProbeRay> rays) {
  const View camera(field.window.frustum(), view.T_anchor_camera);
  const int count = field.samples_per_ray, slot = field.window.frame(view.frame).slot;
  static_.n = dynamic_.n = whole_runs(static_cast<int>(rays.size()) * count);
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
void FieldProbe::move_to_frame(const Cameras& cameras, const ProbeView& view, int rays) {
  const int n = view.offset > 0 ? 0 : 1;
  for (int r = 0; r < rays; ++r)
    for (int k = 0; k < ray_[static_cast<std::size_t>(r)].count; ++k) {
      const int s = r * ray_[static_cast<std::size_t>(r)].count + k;
      const float* point = ray_[static_cast<std::size_t>(r)].position[k];
      float base[kBaseChannels];
      const float prior = cameras.base_at(point, base);
      const auto sample = decode_dynamic(dynamic_.raw, s, base, prior);
      for (int a = 0; a < 3; ++a)
        dynamic_.position.plane(a)[s] =
            point[a] - std::abs(view.offset) * sample.flow[n][a] * cameras.flow_unit[a];
    }
}

// From raw outputs to the samples of ray r, each with the base where the frame sees it.
void FieldProbe::decode(const Cameras& cameras, const ProbeView& view, int r, StateShares& known) {
  RaySamples<float>& ray = ray_[static_cast<std::size_t>(r)];
  for (int k = 0; k < ray.count; ++k) {
    const int s = r * ray.count + k;
    float base[kBaseChannels];
    float prior = cameras.base_at(ray.position[k], base);
    ray.static_[k] = decode_static(static_.raw, s, base, prior);
    known.of_static[k] = 1 - mean_gate(base);
    if (!ray.has_dynamic) continue;
    if (view.offset != 0) {
      const float point[3] = {dynamic_.position.plane(0)[s], dynamic_.position.plane(1)[s],
                              dynamic_.position.plane(2)[s]};
      prior = cameras.base_at(point, base);
    }
    ray.dynamic[k] = decode_dynamic(dynamic_.raw, s, base, prior);
    known.of_dynamic[k] = 1 - mean_gate(base);
  }
}

ProbeAnswer FieldProbe::answer(const Cameras& cameras, Blend blend, const ProbeRay& probe, int r,
                               const StateShares& known) const {
  const RaySamples<float>& ray = ray_[static_cast<std::size_t>(r)];
  RayTrace<float> trace;
  const RayPicture<float> picture = render_ray(ray, blend, trace);
  ProbeAnswer answer{{picture.radiance[0], picture.radiance[1], picture.radiance[2]},
                     picture.inverse_depth,
                     0,
                     {{0, 0}, {0, 0}}};
  for (int k = 0; k < ray.count; ++k) {
    const float dynamic_weight = trace.combined.weight[k] * trace.combined.share[k];
    const float static_weight = trace.combined.weight[k] - dynamic_weight;
    answer.confidence +=
        static_weight * known.of_static[k] + (ray.has_dynamic ? dynamic_weight * known.of_dynamic[k] : 0);
    for (int n = 0; n < 2; ++n) {
      float landing[3];
      cameras.of_neighbour[n].project(ray.position[k], landing, nullptr);
      for (int a = 0; a < 2; ++a) answer.flow[n][a] += static_weight * (landing[a] - probe.pixel[a]);
      if (!ray.has_dynamic) continue;
      const int s = r * ray.count + k;
      float point[3];
      for (int a = 0; a < 3; ++a)
        point[a] = dynamic_.position.plane(a)[s] + ray.dynamic[k].flow[n][a] * cameras.flow_unit[a];
      cameras.of_neighbour[n].project(point, landing, nullptr);
      for (int a = 0; a < 2; ++a) answer.flow[n][a] += dynamic_weight * (landing[a] - probe.pixel[a]);
    }
  }
  return answer;
}

}  // namespace hdrcam
