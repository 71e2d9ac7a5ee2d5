// The state on a graphics device. A frame's codes and motion go there, what is known of its pixels comes
// back; between frames the state stays there and here. When the device fails, the processor goes on from the
// copy that is here, with the same frame. Thread-bound; pool and device outlive it.
#pragma once

#include <array>
#include <memory>
#include <optional>

#include "online/state/cpu_state.h"
#include "online/state/vulkan/state_passes.h"

namespace hdrcam {

class VulkanState final : public StateLayer {
 public:
  VulkanState(const StateOptions& options, int rows, int cols, WorkerPool& pool, GpuDevice& device);

  ~VulkanState() override;

  void restart(const StateInput& input) override;
  void forget_residuals() override;
  void advance(const StateInput& input, const FlowField& to_previous) override;
  void join(const RadianceEstimate& of, std::span<const LaterFrame> later, float unseen_variance,
            JoinedState& joined) override;
  const RadianceState& state() const override { return processor_ ? processor_->state() : known_; }
  const SampleResiduals& residuals() const override {
    return processor_ ? processor_->residuals() : residuals_;
  }
  std::string fallback_reason() const override { return fallback_reason_; }

 private:
  // A frame's codes go to the device once: it is looked ahead to before it is due.
  struct HeldCodes {
    int frame = -1;  // ExposedFrame::index; -1: none
    GpuPicture codes;
  };
  // What lives on the device.
  struct Room {
    StatePasses passes;
    GpuTables tables;
    GpuPicture state, predicted, joined;  // [kStatePlanes]
    GpuPicture samples, motion, path, longer, seen, brightest;
    std::array<HeldCodes, 1 + kMaxLookAhead> held;
    PassRoom room;
    GpuPicture contrast, gate, share, residuals;

    static Result<Room> make(GpuDevice& device, const StateOptions& options, int rows, int cols);
  };

  Result<void> restart_gpu(const StateInput& input);
  Result<void> advance_gpu(const StateInput& input, const FlowField& to_previous);
  Result<void> join_gpu(const RadianceEstimate& of, std::span<const LaterFrame> later, float unseen_variance,
                        JoinedState& joined);
  const GpuPicture& codes_of(const ExposedFrame& frame);
  void upload_motion(const FlowField& motion);
  void download_known(const GpuPicture& state);
  void learn_residuals(float exposure);
  CpuState& fall_back_to_cpu(const Error& why);

  StateOptions options_;
  int rows_, cols_;
  WorkerPool& pool_;
  GpuDevice& device_;
  std::optional<Room> room_;
  std::unique_ptr<CpuState> processor_;  // once the device has failed
  std::string fallback_reason_;
  RadianceState known_;
  SampleResiduals residuals_;
  Image<float> found_;
};

}  // namespace hdrcam
