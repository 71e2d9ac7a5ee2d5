#include "online/scene/hash_grid/fit/vulkan/fit_passes.h"

#include <bit>

#include "online/scene/hash_grid/field/vulkan/encode.comp.h"
#include "online/scene/hash_grid/field/vulkan/network.comp.h"
#include "online/scene/hash_grid/fit/vulkan/adam_network.comp.h"
#include "online/scene/hash_grid/fit/vulkan/adam_table.comp.h"
#include "online/scene/hash_grid/fit/vulkan/backward.comp.h"
#include "online/scene/hash_grid/fit/vulkan/composite_backward.comp.h"
#include "online/scene/hash_grid/fit/vulkan/follow.comp.h"
#include "online/scene/hash_grid/fit/vulkan/measure.comp.h"
#include "online/scene/hash_grid/fit/vulkan/outer.comp.h"
#include "online/scene/hash_grid/fit/vulkan/render.comp.h"
#include "online/scene/hash_grid/fit/vulkan/scatter.comp.h"
#include "online/scene/hash_grid/fit/vulkan/sum.comp.h"
#include "online/scene/hash_grid/fit/vulkan/warp_backward.comp.h"

namespace hdrcam {
namespace {

// fit_constants.glsl
struct RayConstants {
  float focal[2], centre[2], size[2];
  float margin;
  int rays;
  float unit[3];
  int samples, ld, has_dynamic, weighted;

  explicit RayConstants(const GpuRays& of)
      : focal{real(of.frustum().camera.fx_px), real(of.frustum().camera.fy_px)},
        centre{real(of.frustum().camera.cx_px), real(of.frustum().camera.cy_px)},
        size{static_cast<float>(of.frustum().cols), static_cast<float>(of.frustum().rows)},
        margin(of.frustum().margin),
        rays(of.rays()),
        unit{},
        samples(of.samples()),
        ld(of.ld()),
        has_dynamic(of.has_dynamic() ? 1 : 0),
        weighted(of.blends_by_weight() ? 1 : 0) {
    flow_units(of.frustum(), unit);
  }
  static float real(double v) { return static_cast<float>(v); }
};

// network.comp and backward.comp
struct NetworkConstants {
  int first, count, ld, inputs, hidden, outputs, plane_of_raw;

  NetworkConstants(const GpuBranch& branch, int row, SampleRange samples)
      : first(samples.first),
        count(samples.count),
        ld(row),
        inputs(branch.inputs),
        hidden(branch.hidden),
        outputs(branch.outputs),
        plane_of_raw(branch.plane_of_raw) {}
};

// Of the whole numbers that gradients are added up in (fixed_point.glsl).
int count_bits(int samples) { return static_cast<int>(std::bit_width(static_cast<unsigned>(samples - 1))); }

}  // namespace

Result<FitPasses> FitPasses::make(GpuDevice& device) {
  const std::array<GpuShader, kPasses> shaders{{{"field encode", k_encode, 4},
                                                {"field network", k_network, 3},
                                                {"fit follow", k_follow, 5},
                                                {"fit render", k_render, 6},
                                                {"fit composite backward", k_composite_backward, 7},
                                                {"fit backward", k_backward, 6},
                                                {"fit warp backward", k_warp_backward, 6},
                                                {"fit outer", k_outer, 3},
                                                {"fit sum", k_sum, 2},
                                                {"fit measure", k_measure, 3},
                                                {"fit scatter", k_scatter, 5},
                                                {"fit adam table", k_adam_table, 5},
                                                {"fit adam network", k_adam_network, 4}}};
  FitPasses made(device);
  made.kernels_ = TRY(kernels_of(device, shaders));
  return made;
}

void FitPasses::forward(const GpuBranch& branch, const GpuRays& rays, SampleRange samples) const {
  const struct {
    int first, count, ld, slot, level_size;
  } grid{samples.first, samples.count, rays.ld(), branch.slot(), branch.level_size()};
  GpuWork& work = device_->work();
  work.run(*kernels_[kEncode], {*rays.placed, *branch.tables, *branch.features, *branch.lattice}, grid,
           {samples.count, 1, branch.levels});
  work.run(*kernels_[kNetwork], {*branch.features, *rays.raw, *branch.network},
           NetworkConstants(branch, rays.ld(), samples), {samples.count, 1, 1});
}

void FitPasses::follow(const GpuRays& rays) const {
  device_->work().run(*kernels_[kFollow], {*rays.told, *rays.placed, *rays.raw, *rays.views, *rays.bases},
                      RayConstants(rays), {rays.count(), 1, 1});
}

void FitPasses::render(const GpuRays& rays) const {
  device_->work().run(*kernels_[kRender],
                      {*rays.told, *rays.placed, *rays.raw, *rays.views, *rays.bases, *rays.seen},
                      RayConstants(rays), {rays.rays(), 1, 1});
}

void FitPasses::composite_backward(const GpuRays& rays) const {
  device_->work().clear(**rays.d_raw);  // the kernel leaves out what has no gradient
  device_->work().run(
      *kernels_[kCompositeBackward],
      {*rays.told, *rays.placed, *rays.raw, *rays.views, *rays.bases, *rays.d_seen, *rays.d_raw},
      RayConstants(rays), {rays.rays(), 1, 1});
}

void FitPasses::backward(const GpuBranch& branch, const GpuRays& rays, SampleRange samples) const {
  device_->work().run(*kernels_[kBackward],
                      {*branch.features, *rays.d_raw, *branch.network, *branch.trace,
                       *branch.d_pre_activation, *branch.d_features},
                      NetworkConstants(branch, rays.ld(), samples), {samples.count, 1, 1});
}

void FitPasses::warp_backward(const GpuBranch& dynamic, const GpuRays& rays) const {
  struct {
    float unit[3];
    int count, samples, ld, levels, level_size, d_place, plane_of_flow;
  } constants{{},
              rays.count(),
              rays.samples(),
              rays.ld(),
              dynamic.levels,
              dynamic.level_size(),
              GpuRays::kPlacePlane,
              dynamic.plane_of_raw + DynamicHead::kFlow};
  flow_units(rays.frustum(), constants.unit);
  device_->work().run(
      *kernels_[kWarpBackward],
      {*rays.told, *rays.placed, *dynamic.tables, *dynamic.d_features, *rays.d_raw, *dynamic.lattice},
      constants, {rays.count(), 1, 1});
}

void FitPasses::add_up(const GpuBranch& branch, int ld, int count) const {
  GpuWork& work = device_->work();
  const int per_chunk = GpuBranch::per_chunk(count), chunks = GpuBranch::chunks(count);
  const int in = branch.inputs / 4, hidden = branch.hidden / 4, out = branch.outputs / 4;
  const struct {
    int count, per_chunk, inputs, hidden, outputs, parameters;
  } outer{count, per_chunk, in, hidden, out, branch.parameters / 4};
  const int tiles = hidden * (1 + in) + hidden * (1 + hidden) + out * (1 + hidden);
  work.run(*kernels_[kOuter], {*branch.trace, *branch.d_pre_activation, *branch.sums}, outer,
           {tiles, chunks, 1});
  const struct { int parameters, chunks; } sum{branch.parameters / 4, chunks};
  work.run(*kernels_[kSum], {*branch.sums, *branch.d_network}, sum, {sum.parameters, 1, 1});
  const struct { int count, per_chunk, chunks, ld; } measure{count, per_chunk, chunks, ld};
  work.clear(**branch.peaks);
  work.run(*kernels_[kMeasure], {*branch.d_features, *branch.energy, *branch.peaks}, measure,
           {chunks, branch.inputs, 1});
}

void FitPasses::scatter(const GpuBranch& branch, const GpuRays& rays, int count) const {
  const struct {
    int count, ld, slot, level_size, count_bits;
  } constants{count, rays.ld(), branch.slot(), branch.level_size(), count_bits(count)};
  device_->work().run(*kernels_[kScatter],
                      {*rays.placed, *branch.d_features, *branch.peaks, *branch.d_tables, *branch.lattice},
                      constants, {count, 1, branch.levels});
}

void FitPasses::adam(const GpuBranch& branch, const AdamStep& table_step, const AdamStep& network_step,
                     int count) const {
  GpuWork& work = device_->work();
  const struct {
    AdamStep step;
    int entries, level_size, count_bits;
  } tables{table_step, branch.entries, branch.level_size(), count_bits(count)};
  work.run(*kernels_[kAdamTable],
           {*branch.tables, *branch.d_tables, *branch.table_mean, *branch.table_variance, *branch.peaks},
           tables, {branch.entries, branch.slots, branch.levels});
  const struct {
    AdamStep step;
    int count;
  } network{network_step, branch.parameters};
  work.run(*kernels_[kAdamNetwork],
           {*branch.network, *branch.d_network, *branch.network_mean, *branch.network_variance}, network,
           {branch.parameters, 1, 1});
}

}  // namespace hdrcam
