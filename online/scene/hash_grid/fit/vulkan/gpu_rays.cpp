#include "online/scene/hash_grid/fit/vulkan/gpu_rays.h"

#include "online/scene/hash_grid/field/vulkan/branch_layout.h"

namespace hdrcam {
namespace {

constexpr std::size_t kMostFrames = WindowOptions::kMostFrames;
static_assert(kMostFrames * kViewFloats == 84 * 4,
              "views[84] in follow.comp, render.comp and composite_backward.comp has a view for each frame");

// Of what is seen of a ray, and of one of its samples (render.comp).
enum SeenOfRay : int { kRadiance = 0, kLanding = 3, kDepth = 5, kShare = 6, kVisible = 7, kWarped = 8 };
enum SeenOfSample : int { kWeight = 0, kFlow = 1, kOcclusion = 7, kFlowBack = 8 };
enum PlacedPlane : int { kSlot = 3, kInverseDepth = 4, kSpacing = 5 };

}  // namespace

Result<void> GpuRays::reserve(GpuDevice& device, const WindowFrames& window, int rays, int samples) {
  const auto floats = [](int a, int b) {
    return static_cast<std::size_t>(a) * static_cast<std::size_t>(b) * sizeof(float);
  };
  const int most = rays * samples;
  TRY(views.reserve(device, kMostFrames * kViewFloats * sizeof(float)));
  TRY(bases.reserve(device,
                    static_cast<std::size_t>(window.size()) * window.newest().base.samples().size_bytes()));
  TRY(told.reserve(device, floats(kToldFloats, rays)));
  TRY(placed.reserve(device, floats(kPlacedPlanes, 2 * most)));
  TRY(raw.reserve(device, floats(kRawPlanes, 2 * most)));
  TRY(d_raw.reserve(device, floats(kGradientPlanes, 2 * most)));
  TRY(seen.reserve(device, floats(kSeenPlanes, rays + most)));
  return d_seen.reserve(device, floats(kSeenPlanes, rays + most));
}

void GpuRays::upload_window(GpuWork& work, const WindowFrames& window) {
  std::vector<float> cameras;
  bases_.clear();
  for (int i = 0; i < window.size(); ++i) {
    const WindowFrame& frame = window.frame(i);
    append_view(window.frustum(), frame.T_anchor_camera, cameras);
    bases_.insert(bases_.end(), frame.base.samples().begin(), frame.base.samples().end());
  }
  work.upload(bytes_of_numbers(cameras), **views);
  work.upload(bytes_of_numbers(bases_), **bases);
}

void GpuRays::begin(const StepSetting<float>& step, std::size_t rays) {
  rays_ = static_cast<int>(rays), samples_ = step.samples_per_ray;
  has_dynamic_ = step.has_dynamic;
  weighted_ = step.networks.blend == Blend::Weight;
  frustum_ = &step.window.frustum();
  told_.assign(rays * kToldFloats, 0);
  placed_.assign(place_in(kPlacedPlanes, ld(), 0), 0);
  seen_.resize(place_in(kSeenPlanes, rays_ + count(), 0));
  d_seen_.resize(seen_.size());
}

void GpuRays::place(const StepSetting<float>& step, std::span<const TrainingRay> rays, std::size_t first,
                    Pcg32 random) {
  const auto at = [&](int plane, std::size_t s) -> float& { return placed_[place_in(plane, ld(), s)]; };
  RaySamples<float> ray;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    float* const told_here = told_.data() + (first + i) * kToldFloats;
    place_ray(step, rays[i], random, ray, told_here);
    float* const aim = told_here + kBaseChannels;
    aim[0] = -1;
    if (ray.warps) {
      const int there = neighbour_of(rays[i]);
      aim[0] = static_cast<float>(there), aim[1] = static_cast<float>(ray.toward);
      aim[2] = static_cast<float>(step.window.frame(there).slot);
    }
    for (int k = 0; k < ray.count; ++k) {
      const std::size_t s = (first + i) * static_cast<std::size_t>(ray.count) + static_cast<std::size_t>(k);
      for (int a = 0; a < 3; ++a) at(a, s) = ray.position[k][a];
      at(kSlot, s) = static_cast<float>(step.window.frame(rays[i].frame).slot);
      at(kInverseDepth, s) = ray.inverse_depth[k], at(kSpacing, s) = ray.spacing[k];
    }
  }
}

void GpuRays::upload_placed(GpuWork& work) const {
  work.upload(bytes_of_numbers(told_), **told);
  work.upload(bytes_of_numbers(placed_), **placed);
}

void GpuRays::download_seen(GpuWork& work) {
  work.download(**seen, std::as_writable_bytes(std::span(seen_)));
}

void GpuRays::upload_d_seen(GpuWork& work) const { work.upload(bytes_of_numbers(d_seen_), **d_seen); }

void GpuRays::unpack(const TrainingRay& target, std::size_t r, RaySamples<float>& ray,
                     RayPicture<float>& picture, RayTrace<float>& trace) {
  const float* const told_here = told_.data() + r * kToldFloats;
  ray.count = trace.combined.count = samples_;
  ray.has_dynamic = has_dynamic_;
  ray.warps = has_dynamic_ && target.warps;
  ray.toward = target.toward;
  const auto there = static_cast<std::size_t>(target.toward), back = 1 - there;
  for (int c = 0; c < 3; ++c) {
    picture.radiance[c] = seen_of_ray(seen_, kRadiance + c, r);
    picture.warped_radiance[c] = seen_of_ray(seen_, kWarped + c, r);
  }
  for (int a = 0; a < 2; ++a) picture.landing[a] = seen_of_ray(seen_, kLanding + a, r);
  picture.inverse_depth = seen_of_ray(seen_, kDepth, r), picture.share = seen_of_ray(seen_, kShare, r);
  picture.visible = seen_of_ray(seen_, kVisible, r);
  for (int k = 0; k < samples_; ++k) {
    const std::size_t s = r * static_cast<std::size_t>(samples_) + static_cast<std::size_t>(k);
    const auto placed_at = [&](int plane) { return placed_[place_in(plane, ld(), s)]; };
    for (int a = 0; a < 3; ++a) ray.position[k][a] = placed_at(a);
    ray.inverse_depth[k] = placed_at(kInverseDepth);
    trace.combined.weight[k] = seen_of_sample(seen_, kWeight, s);
    if (!has_dynamic_) continue;
    FieldSample<float>& dynamic = ray.dynamic[k];
    for (int n = 0; n < 2; ++n)
      for (int a = 0; a < 3; ++a) {
        dynamic.flow_residual[n][a] = seen_of_sample(seen_, kFlow + 3 * n + a, s);
        dynamic.flow[n][a] = dynamic.flow_residual[n][a] + (a < 2 ? told_here[kBaseFlow + 2 * n + a] : 0);
      }
    if (!ray.warps) continue;
    dynamic.occlusion[there] = seen_of_sample(seen_, kOcclusion, s);
    for (int a = 0; a < 3; ++a) ray.warped[k].flow[back][a] = seen_of_sample(seen_, kFlowBack + a, s);
  }
}

void GpuRays::pack(std::size_t r, const RaySamples<float>& ray, const RayGradient<float>& gradient) {
  const RaySamples<float>& d_ray = gradient.samples;
  const RayPicture<float>& d_picture = gradient.picture;
  for (int c = 0; c < 3; ++c) {
    seen_of_ray(d_seen_, kRadiance + c, r) = d_picture.radiance[c];
    seen_of_ray(d_seen_, kWarped + c, r) = d_picture.warped_radiance[c];
  }
  for (int a = 0; a < 2; ++a) seen_of_ray(d_seen_, kLanding + a, r) = d_picture.landing[a];
  seen_of_ray(d_seen_, kDepth, r) = d_picture.inverse_depth;
  seen_of_ray(d_seen_, kShare, r) = d_picture.share;
  seen_of_ray(d_seen_, kVisible, r) = d_picture.visible;
  const auto there = static_cast<std::size_t>(ray.toward), back = 1 - there;
  for (int k = 0; k < samples_; ++k) {
    const std::size_t s = r * static_cast<std::size_t>(samples_) + static_cast<std::size_t>(k);
    const FieldSample<float>& dynamic = d_ray.dynamic[k];
    seen_of_sample(d_seen_, kWeight, s) = gradient.weight[k];
    for (int n = 0; n < 2; ++n)
      for (int a = 0; a < 3; ++a)
        seen_of_sample(d_seen_, kFlow + 3 * n + a, s) = dynamic.flow[n][a] + dynamic.flow_residual[n][a];
    seen_of_sample(d_seen_, kOcclusion, s) = dynamic.occlusion[there];
    for (int a = 0; a < 3; ++a) seen_of_sample(d_seen_, kFlowBack + a, s) = d_ray.warped[k].flow[back][a];
  }
}

void GpuRays::losses(const StepSetting<float>& step, std::span<const TrainingRay> rays, std::size_t first,
                     ShardLosses<float>& sums, std::span<float> misfit) {
  RaySamples<float> ray;
  RayTrace<float> trace;
  RayPicture<float> picture;
  RayGradient<float> gradient;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    unpack(rays[i], first + i, ray, picture, trace);
    misfit[i] = sums.add(step, rays[i], {ray, trace, picture}, gradient);
    pack(first + i, ray, gradient);
  }
}

}  // namespace hdrcam
