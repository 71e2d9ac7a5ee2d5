#include "online/scene/hash_grid/field/vulkan/vulkan_probe.h"

#include "online/scene/hash_grid/field/vulkan/answer.comp.h"
#include "online/scene/hash_grid/field/vulkan/branch_layout.h"
#include "online/scene/hash_grid/field/vulkan/encode.comp.h"
#include "online/scene/hash_grid/field/vulkan/move.comp.h"
#include "online/scene/hash_grid/field/vulkan/network.comp.h"
#include "online/scene/hash_grid/field/vulkan/place.comp.h"

namespace hdrcam {
namespace {

constexpr std::size_t kBatchRays = 16384;  // 27 MB of memory at 8 samples a ray
constexpr std::size_t kPlacedPlanes = 5, kAnswerPlanes = 9, kViews = 4;

}  // namespace

// field_constants.glsl
struct VulkanProbe::Constants {
  float focal[2], centre[2], size[2];
  float margin, offset;
  float unit[3];
  int rays, samples, ld, has_dynamic, weighted;
};

Result<std::unique_ptr<VulkanProbe>> VulkanProbe::make(GpuDevice& device) {
  const std::array<GpuShader, kPasses> shaders{{{"field place", k_place, 4},
                                                {"field encode", k_encode, 4},
                                                {"field network", k_network, 3},
                                                {"field move", k_move, 5},
                                                {"field answer", k_answer, 8}}};
  std::unique_ptr<VulkanProbe> probe(new VulkanProbe(device));
  const GpuTurn turn(device);  // ends before `probe`, whose end takes a turn of its own
  probe->kernels_ = TRY(kernels_of(device, shaders));
  return probe;
}

VulkanProbe::~VulkanProbe() {
  const GpuTurn turn(device_);
  static_ = {}, dynamic_ = {};
  for (GpuRoom* room : {&rays_, &placed_, &moved_, &views_, &base_, &answers_}) room->buffer.reset();
}

Result<void> VulkanProbe::look(const RadianceField& field, const ProbeView& view,
                               std::span<const ProbeRay> rays, std::span<ProbeAnswer> answers) {
  HDRCAM_CHECK(answers.size() == rays.size());
  const GpuTurn turn(device_);
  const std::size_t batch = std::min(kBatchRays, rays.size());
  const int ld = static_cast<int>(batch) * field.samples_per_ray;
  TRY(reserve_for(field, ld));  // all of it before the first step: work that was begun is finished
  upload(field, view);
  for (std::size_t first = 0; first < rays.size(); first += batch) {
    const std::size_t n = std::min(batch, rays.size() - first);
    TRY(look_at_batch(field, view, rays.subspan(first, n), answers.subspan(first, n)));
  }
  return {};
}

Result<void> VulkanProbe::reserve_for(const Branch<float>& branch, int ld, BranchRoom& room) {
  const auto rows = [&](int count) {
    return static_cast<std::size_t>(count) * static_cast<std::size_t>(ld) * sizeof(float);
  };
  TRY(check_fits_kernels(branch.mlp));
  TRY(room.tables.reserve(device_, branch.grid.tables().samples().size_bytes()));
  TRY(room.levels.reserve(device_, kMostLevels * kLevelWords * sizeof(std::uint32_t)));
  TRY(room.parameters.reserve(device_, branch_constants::kMostParameters * sizeof(float)));
  TRY(room.features.reserve(device_, rows(branch.mlp.inputs())));
  return room.raw.reserve(device_, rows(branch.mlp.outputs()));
}

Result<void> VulkanProbe::reserve_for(const RadianceField& field, int ld) {
  const auto samples = static_cast<std::size_t>(ld) * sizeof(float);
  TRY(views_.reserve(device_, kViews * kViewFloats * sizeof(float)));
  TRY(base_.reserve(device_, field.window.newest().base.samples().size_bytes()));
  TRY(rays_.reserve(device_, kBatchRays * sizeof(ProbeRay)));
  TRY(answers_.reserve(device_, kBatchRays * kAnswerPlanes * sizeof(float)));
  TRY(placed_.reserve(device_, kPlacedPlanes * samples));
  TRY(moved_.reserve(device_, 3 * samples));
  TRY(reserve_for(field.networks.static_, ld, static_));
  return reserve_for(field.networks.dynamic, ld, dynamic_);
}

void VulkanProbe::upload(const Branch<float>& branch, const BranchRoom& room) {
  GpuWork& work = device_.work();
  work.upload(bytes_of_numbers(branch.grid.tables().samples()), *room.tables.buffer);
  work.upload(bytes_of_numbers(words_of(branch.grid)), *room.levels.buffer);
  work.upload(bytes_of_numbers(tiled(branch.mlp, branch.mlp.parameters())), *room.parameters.buffer);
}

void VulkanProbe::upload(const RadianceField& field, const ProbeView& view) {
  const WindowFrames& window = field.window;
  const WindowFrame& frame = window.frame(view.frame);
  const bool has_next = view.frame + 1 < window.size(), has_previous = view.frame > 0;
  std::vector<float> views;
  for (const RigidTransform* T_anchor_camera :
       {&view.T_anchor_camera, &frame.T_anchor_camera,
        has_next ? &window.frame(view.frame + 1).T_anchor_camera : &view.T_anchor_camera,
        has_previous ? &window.frame(view.frame - 1).T_anchor_camera : &view.T_anchor_camera})
    append_view(window.frustum(), *T_anchor_camera, views);
  device_.work().upload(bytes_of_numbers(views), *views_.buffer);
  device_.work().upload(bytes_of_numbers(frame.base.samples()), *base_.buffer);
  upload(field.networks.static_, static_);
  upload(field.networks.dynamic, dynamic_);
}

void VulkanProbe::forward(const Branch<float>& branch, int slot, const GpuRoom& position, int count, int ld,
                          BranchRoom& room) {
  GpuWork& work = device_.work();
  const struct {
    int first, count, ld, slot, level_size;
  } grid{0, count, ld, slot, branch.grid.tables().cols() / 2};
  work.run(*kernels_[kEncode], {*position, *room.tables, *room.features, *room.levels}, grid,
           {count, 1, branch.grid.shape().levels});
  const Mlp<float>& mlp = branch.mlp;
  const struct {
    int first, count, ld, inputs, hidden, outputs, plane_of_raw;
  } network{0, count, ld, mlp.inputs(), mlp.hidden(), mlp.outputs(), 0};
  work.run(*kernels_[kNetwork], {*room.features, *room.raw, *room.parameters}, network, {count, 1, 1});
}

Result<void> VulkanProbe::look_at_batch(const RadianceField& field, const ProbeView& view,
                                        std::span<const ProbeRay> rays, std::span<ProbeAnswer> answers) {
  GpuWork& work = device_.work();
  const WindowFrustum& frustum = field.window.frustum();
  const auto count = static_cast<int>(rays.size());
  const int samples = count * field.samples_per_ray, slot = field.window.frame(view.frame).slot;
  const auto real = [](double v) { return static_cast<float>(v); };
  Constants constants{{real(frustum.camera.fx_px), real(frustum.camera.fy_px)},
                      {real(frustum.camera.cx_px), real(frustum.camera.cy_px)},
                      {static_cast<float>(frustum.cols), static_cast<float>(frustum.rows)},
                      frustum.margin,
                      view.offset,
                      {},
                      count,
                      field.samples_per_ray,
                      samples,
                      field.has_dynamic ? 1 : 0,
                      field.networks.blend == Blend::Weight ? 1 : 0};
  flow_units(frustum, constants.unit);
  static_assert(sizeof(ProbeRay) == 3 * sizeof(float));
  work.upload(bytes_of_numbers(rays), *rays_.buffer);
  work.run(*kernels_[kPlace], {*rays_, *views_, *base_, *placed_}, constants, {count, 1, 1});
  forward(field.networks.static_, 0, placed_, samples, samples, static_);
  const GpuRoom* position = &placed_;
  if (field.has_dynamic) {
    forward(field.networks.dynamic, slot, placed_, samples, samples, dynamic_);
    if (view.offset != 0) {
      work.run(*kernels_[kMove], {*placed_, *dynamic_.raw, *views_, *base_, *moved_}, constants,
               {samples, 1, 1});
      forward(field.networks.dynamic, slot, moved_, samples, samples, dynamic_);
      position = &moved_;
    }
  }
  work.run(*kernels_[kAnswer],
           {*rays_, *placed_, *static_.raw, *dynamic_.raw, **position, *views_, *base_, *answers_}, constants,
           {count, 1, 1});
  fetched_.resize(kAnswerPlanes * rays.size());
  work.download(*answers_.buffer, std::as_writable_bytes(std::span(fetched_)));
  TRY(work.finish());
  const auto value = [&](std::size_t plane, std::size_t r) { return fetched_[plane * rays.size() + r]; };
  for (std::size_t r = 0; r < rays.size(); ++r) {
    ProbeAnswer& answer = answers[r];
    for (std::size_t c = 0; c < 3; ++c) answer.radiance[c] = value(c, r);
    answer.inverse_depth = value(3, r), answer.confidence = value(4, r);
    for (std::size_t n = 0; n < 2; ++n)
      for (std::size_t a = 0; a < 2; ++a) answer.flow[n][a] = value(5 + 2 * n + a, r);
  }
  return {};
}

}  // namespace hdrcam
