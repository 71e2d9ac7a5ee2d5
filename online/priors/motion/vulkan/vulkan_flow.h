// The dense flow on a graphics device. Two pictures and a guess go there, two flows come back. When the
// device fails, the processor finds the flow of the same pictures, and of all later ones. Thread-bound; pool
// and device outlive it.
#pragma once

#include <optional>
#include <vector>

#include "online/priors/motion/cpu_flow.h"
#include "online/priors/motion/vulkan/flow_passes.h"

namespace hdrcam {

class VulkanFlow final : public DenseFlow {
 public:
  // For pictures of this size.
  VulkanFlow(int rows, int cols, WorkerPool& pool, GpuDevice& device);
  ~VulkanFlow() override;

  void compute(FlowQuality quality, const FlowRequest& request) override;
  std::string fallback_reason() const override { return fallback_reason_; }

 private:
  // What lives on the device. Vectors and all that a scale is solved with lie in the first samples of
  // pictures of full size.
  struct Room {
    FlowPasses passes;
    std::vector<GpuPicture> levels;  // by scale
    GpuPicture guess;
    GpuPicture flow, before, next;       // found; what a refinement begins with; what a sweep writes
    GpuPicture patches, starts, others;  // [kFlowVectorPlanes] of the patches
    GpuPicture data, system;

    static Result<Room> make(GpuDevice& device, int rows, int cols);
  };

  Result<void> compute_gpu(FlowQuality quality, const FlowRequest& request);
  GpuFlowGuess upload_guess(const FlowRequest& request);
  Result<void> search_far(const GpuFlowLevel& level, int steps);
  void refine(const GpuPicture& level, const FlowEffort& effort);
  void fall_back_to_cpu(const Error& why);

  const int rows_, cols_;
  WorkerPool& pool_;
  GpuDevice& device_;
  std::optional<Room> room_;
  std::optional<CpuFlow> processor_;  // once the device has failed
  std::string fallback_reason_;
  std::array<Image<float>, 2> found_, far_, agreed_, far_back_;  // [u v, patches], by direction
};

}  // namespace hdrcam
