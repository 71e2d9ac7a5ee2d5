// The state on the processor: the recursion and the look-ahead with one room for both. Thread-bound.
#pragma once

#include "online/state/state_layer.h"

namespace hdrcam {

class CpuState final : public StateLayer {
 public:
  CpuState(const StateOptions& options, int rows, int cols, WorkerPool& pool)
      : filter_(options, rows, cols, pool), look_ahead_(pool) {}

  void restart(const StateInput& input) override { filter_.restart(input); }
  void forget_residuals() override { filter_.forget_residuals(); }
  void advance(const StateInput& input, const FlowField& to_previous) override {
    filter_.advance(input, to_previous);
  }
  void join(const RadianceEstimate& of, std::span<const LaterFrame> later, float unseen_variance,
            JoinedState& joined) override {
    look_ahead_.join(of, later, unseen_variance, filter_.fusion(), joined);
  }
  // Goes on from what another layer knew.
  void resume(const RadianceState& state, const SampleResiduals& residuals) {
    filter_.resume(state, residuals);
  }

  const RadianceState& state() const override { return filter_.state(); }
  const SampleResiduals& residuals() const override { return filter_.residuals(); }

 private:
  StateFilter filter_;
  LookAhead look_ahead_;
};

}  // namespace hdrcam
