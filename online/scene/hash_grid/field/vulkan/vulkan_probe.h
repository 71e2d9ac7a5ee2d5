// Asks the field what rays see, as FieldProbe does, on a graphics device and for thousands of rays at once.
// It takes the device's turn for each call, so a view may be looked at by another thread than that of the
// fit. Thread-bound but for that; the device outlives it.
#pragma once

#include <array>

#include "online/scene/hash_grid/field/field_probe.h"
#include "online/scene/hash_grid/field/vulkan/gpu_room.h"

namespace hdrcam {

class VulkanProbe {
 public:
  static Result<std::unique_ptr<VulkanProbe>> make(GpuDevice& device);
  ~VulkanProbe();

  // answers has the size of rays; on an error some of it may be written. Errors: those of the device.
  Result<void> look(const RadianceField& field, const ProbeView& view, std::span<const ProbeRay> rays,
                    std::span<ProbeAnswer> answers);

 private:
  enum Pass : std::size_t { kPlace, kEncode, kNetwork, kMove, kAnswer, kPasses };
  // One branch's parameters and what a batch makes of its samples.
  struct BranchRoom {
    GpuRoom tables, levels, parameters, features, raw;
  };
  struct Constants;

  explicit VulkanProbe(GpuDevice& device) : device_(device) {}
  Result<void> reserve_for(const Branch<float>& branch, int ld, BranchRoom& room);
  Result<void> reserve_for(const RadianceField& field, int ld);
  void upload(const Branch<float>& branch, const BranchRoom& room);
  void upload(const RadianceField& field, const ProbeView& view);
  void forward(const Branch<float>& branch, int slot, const GpuRoom& position, int count, int ld,
               BranchRoom& room);
  Result<void> look_at_batch(const RadianceField& field, const ProbeView& view,
                             std::span<const ProbeRay> rays, std::span<ProbeAnswer> answers);

  GpuDevice& device_;
  std::array<const GpuKernel*, kPasses> kernels_{};
  BranchRoom static_, dynamic_;
  GpuRoom rays_, placed_, moved_, views_, base_, answers_;
  std::vector<float> fetched_;
};

}  // namespace hdrcam
