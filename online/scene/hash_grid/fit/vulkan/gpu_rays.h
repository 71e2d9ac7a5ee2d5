// The rays of one step on their way between processor and graphics device (ray.glsl, render.comp): the CPU
// places them, the device renders them, the CPU computes their losses, and the device propagates the gradient
// backward. Thread-bound; distinct shards of a step may be placed, and have their losses computed, on
// distinct threads.
#pragma once

#include "online/scene/hash_grid/fit/shard_losses.h"
#include "online/scene/hash_grid/fit/vulkan/gpu_branch.h"

namespace hdrcam {

class GpuRays {
 public:
  static constexpr int kRawPlanes = branch_constants::kStaticOutputs + branch_constants::kDynamicOutputs;
  static constexpr int kPlacePlane = kRawPlanes, kGradientPlanes = kRawPlanes + 3;  // of d_raw
  static constexpr int kToldFloats = kBaseChannels + 4, kPlacedPlanes = 6;
  static constexpr int kSeenPlanes = 11;  // per ray, and as many per sample

  // Room for a step's rays and a window's bases. Errors: those of the device.
  Result<void> reserve(GpuDevice& device, const WindowFrames& window, int rays, int samples);
  void upload_window(GpuWork& work, const WindowFrames& window);

  // Starts a step of rays.size() rays.
  void begin(const StepSetting<float>& step, std::size_t rays);
  // Whether it is of the size of the step that was begun last.
  bool is_alike(const StepSetting<float>& step, std::size_t rays) const {
    return static_cast<int>(rays) == rays_ && step.samples_per_ray == samples_ &&
           step.has_dynamic == has_dynamic_;
  }
  // Places rays first .. first + rays.size() - 1.
  void place(const StepSetting<float>& step, std::span<const TrainingRay> rays, std::size_t first,
             Pcg32 random);
  void upload_placed(GpuWork& work) const;
  void download_seen(GpuWork& work);
  // Adds the losses of rays first .. first + rays.size() - 1, from `seen`, to `sums`, and writes their
  // d_seen; misfit: photometric, of each.
  void losses(const StepSetting<float>& step, std::span<const TrainingRay> rays, std::size_t first,
              ShardLosses<float>& sums, std::span<float> misfit);
  void upload_d_seen(GpuWork& work) const;

  int rays() const { return rays_; }
  int samples() const { return samples_; }  // per ray
  int count() const { return rays_ * samples_; }
  // Row length of all buffers of samples: the placed ones, and as many displaced ones.
  int ld() const { return 2 * count(); }
  bool has_dynamic() const { return has_dynamic_; }
  bool blends_by_weight() const { return weighted_; }
  const WindowFrustum& frustum() const { return *frustum_; }

  GpuRoom told, placed, raw, d_raw, views, bases, seen, d_seen;

 private:
  // Of value i of a plane, in planes of `row` values.
  static std::size_t place_in(int plane, int row, std::size_t i) {
    return static_cast<std::size_t>(plane) * static_cast<std::size_t>(row) + i;
  }
  float& seen_of_ray(std::vector<float>& values, int plane, std::size_t r) const {
    return values[place_in(plane, rays_, r)];
  }
  float& seen_of_sample(std::vector<float>& values, int plane, std::size_t s) const {
    return values[place_in(plane, count(), s) + place_in(kSeenPlanes, rays_, 0)];
  }
  void unpack(const TrainingRay& target, std::size_t r, RaySamples<float>& ray, RayPicture<float>& picture,
              RayTrace<float>& trace);
  void pack(std::size_t r, const RaySamples<float>& ray, const RayGradient<float>& gradient);

  int rays_ = 0, samples_ = 0;
  bool has_dynamic_ = false, weighted_ = false;
  const WindowFrustum* frustum_ = nullptr;
  std::vector<float> told_, placed_, seen_, d_seen_;
  std::vector<BasePixel> bases_;
};

}  // namespace hdrcam
