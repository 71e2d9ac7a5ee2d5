// The state as the rest of the pipeline sees it, wherever its passes over the pixels run: on the processor
// (cpu_state.h) or on a graphics device. Pictures go in and come out in the processor's memory. An
// implementation that fails half way goes on with the processor from what it knew, and says so in
// fallback_reason(): no frame is lost. Thread-bound.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "hal/gpu/gpu_device.h"
#include "online/state/look_ahead.h"
#include "online/state/state_filter.h"

namespace hdrcam {

class StateLayer {
 public:
  virtual ~StateLayer() = default;

  // As StateFilter's.
  virtual void restart(const StateInput& input) = 0;
  virtual void forget_residuals() = 0;
  virtual void advance(const StateInput& input, const FlowField& to_previous) = 0;
  // As LookAhead::join; of: state(), or a copy of an earlier one.
  virtual void join(const RadianceEstimate& of, std::span<const LaterFrame> later, float unseen_variance,
                    JoinedState& joined) = 0;

  virtual const RadianceState& state() const = 0;
  virtual const SampleResiduals& residuals() const = 0;
  // Why it no longer runs where it was asked to; "" while it does.
  virtual std::string fallback_reason() const { return {}; }
};

// gpu: where to run, null for the processor; it outlives the layer, as the pool does. What keeps it from
// running there is in fallback_reason().
std::unique_ptr<StateLayer> make_state_layer(const StateOptions& options, int rows, int cols,
                                             WorkerPool& pool, GpuDevice* gpu);

}  // namespace hdrcam
