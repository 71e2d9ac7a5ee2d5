// The state on a graphics device. A frame's codes and motion go there, what is known of its pixels comes
// back; between frames the state stays there and here. When the device fails, the processor goes on from the
// copy that is here, with the same frame. Thread-bound; pool and device outlive it.
#pragma once

#include <memory>
#include <optional>

#include "online/state/cpu_state.h"
#include "online/state/vulkan/state_passes.h"

namespace hdrcam {

class VulkanState final : public StateLayer {
 public:
  VulkanState(const StateOptions& options, int rows, int cols, WorkerPool& pool, GpuDevice& device);

  void restart(const StateInput& input) override;
  void advance(const StateInput& input, const FlowField& to_previous) override;
  void join(const RadianceState& of, std::span<const LaterFrame> later, float white,
            JoinedState& joined) override;
  const RadianceState& state() const override { return processor_ ? processor_->state() : known_; }
  const SampleResiduals& residuals() const override {
    return processor_ ? processor_->residuals() : residuals_;
  }
  std::string trouble() const override { return trouble_; }

 private:
  // What lives on the device.
  struct Room {
    StatePasses passes;
    GpuTables tables;
    GpuPicture state, predicted, joined;  // [kStatePlanes]
    GpuPicture samples, motion, path, longer, codes, seen, largest, brightest;
    PassRoom room;
    GpuPicture contrast, gate, share, residuals;

    static Result<Room> make(GpuDevice& device, const StateOptions& options, int rows, int cols);
  };

  Result<void> restart_there(const StateInput& input);
  Result<void> advance_there(const StateInput& input, const FlowField& to_previous);
  Result<void> join_there(const RadianceState& of, std::span<const LaterFrame> later, float white,
                          JoinedState& joined);
  void upload_motion(const FlowField& motion);
  void take_state();
  void learn_residuals(float exposure);
  CpuState& give_up(const Error& why);

  StateOptions options_;
  int rows_, cols_;
  WorkerPool& pool_;
  GpuDevice& device_;
  std::optional<Room> room_;
  std::unique_ptr<CpuState> processor_;  // once the device has failed
  std::string trouble_;
  RadianceState known_;
  SampleResiduals residuals_;
  Image<float> stacked_, fetched_, fetched_share_, found_;
};

}  // namespace hdrcam
