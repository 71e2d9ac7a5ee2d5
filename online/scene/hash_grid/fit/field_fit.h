// The fit of the window's field to the stream: observe() takes the next frame into the window, step() takes
// one Adam step on a few hundred rays. The field starts from the state's picture (window.h), so it can be
// rendered after any number of steps, also none. Deterministic: the same frames and seed give the same bytes
// for any number of threads. No allocation after the first frame. Thread-bound.
//
// With a graphics device the steps of a frame run there (vulkan/), from a copy of the parameters; field()
// keeps those of before the steps until settle(). When the device fails, the CPU takes all steps since then
// again and goes on.
#pragma once

#include <array>
#include <optional>

#include "hal/core/worker_pool.h"
#include "hal/gpu/gpu_device.h"
#include "online/scene/fit_budget.h"
#include "online/scene/hash_grid/field/field_probe.h"
#include "online/scene/hash_grid/fit/cpu_fit.h"
#include "online/scene/hash_grid/fit/field_options.h"
#include "online/scene/hash_grid/fit/fit_health.h"

namespace hdrcam {

struct StepReport {
  LossValues<double> losses{};  // weighted, by LossTerm
  double total = 0;             // their sum
  double gradient_norm = 0;     // of network weights and grid features
  StepVerdict verdict = StepVerdict::Taken;
};

class VulkanFit;

class FieldFit {
 public:
  // gpu: which takes the steps, null for the processor; it outlives the fit.
  FieldFit(const FieldOptions& options, const Intrinsics& camera, int rows, int cols, WorkerPool& pool,
           GpuDevice* gpu = nullptr);
  ~FieldFit();

  // response: the estimate at this frame; a fit that refines its own ignores it until it is another one than
  // before. Errors: Invalid, BadExposure (window.h); the window is then unchanged.
  Result<void> observe(const FieldObservation& seen, const Response& response);
  // Forgets all frames and what was fitted to them: the window; networks and tables, which are reinitialised,
  // with their last good copies; the usual loss and gradient norm; Adam's moments and the number of steps
  // taken, from which the learning rate's warm-up and Adam's bias correction count. Steps on a graphics
  // device that settle() has not collected are dropped. What survives: the response as it was learned, and
  // the estimate that it began with: a fit that refines it goes on ignoring that one in observe(); the misfit
  // of each tile, by slot, from which pixels are chosen; the state of the random numbers, so that the new
  // networks are other ones; counts(); the budget; and whether the CPU has replaced the device.
  void restart();
  // Sets the budget of the next steps and of rendering.
  void prepare(const FitBudget& budget);
  // Takes one step. Needs a frame; with an empty window it does nothing.
  StepReport step();
  // Ends a frame's steps: what they have learned is in field(), wherever they ran. Does nothing on the
  // processor.
  void settle();
  // Why the steps no longer run on the graphics device; "" while they do, or were not asked to.
  const std::string& fallback_reason() const { return fallback_reason_; }

  // Needs settle() after steps on a device.
  RadianceField field() const {
    HDRCAM_CHECK(!uncollected_.is_open);
    return {window_, networks_, samples_per_ray_, has_dynamic_};
  }
  Window& window() { return window_; }
  // New networks of the same shape, with the random parameters of this seed; the fitted ones stay.
  FieldNetworks<float> fresh_networks(std::uint64_t seed) const;
  const FitCounts& counts() const { return state_.health.counts(); }
  const LearnedResponse<float>& response() const { return state_.response; }

 private:
  // What steps change on the CPU, besides the field's parameters.
  struct StepState {
    Pcg32 random;
    LearnedResponse<float> response;
    AdamMoments response_moments;
    std::vector<PixelPicker> pickers;  // by slot
    FitHealth health;
    long taken = 0;  // Adam steps since its moments were zero
  };
  // Steps on the graphics device that settle() has not collected.
  struct Uncollected {
    bool is_open = false;
    int steps = 0;
    std::optional<StepState> state;  // before them
  };

  // Whether the estimate is another one than when it was last asked for.
  bool became_another(const Response& response);
  void make_ready();
  void begin_on_gpu();
  Result<void> gradients();
  double total_up(StepReport& report);
  void apply(float gradient_scale);
  void apply_response(float gradient_scale);
  void roll_back();
  void forget_steps();
  void fall_back_to_cpu(const Error& why);
  void reanchor();
  void start_networks();

  FieldOptions options_;
  WorkerPool& pool_;
  StepState state_;
  Window window_;
  FieldNetworks<float> networks_;
  FitBudget budget_;
  int samples_per_ray_ = 0;
  bool has_dynamic_ = true;  // false where nothing in the window moves
  OptimisedBranches branches_;
  std::vector<TrainingRay> rays_;    // of the step
  StepSums sums_;                    // of the step
  std::vector<float> table_before_;  // when the anchor moves
  FieldProbe probe_;
  std::array<Response::Curve, 3> estimate_{};  // of the response, that a fit which refines it began with
  bool ready_ = false;                         // for steps on the newest frame
  CpuFit cpu_;
  std::unique_ptr<VulkanFit> gpu_;  // null: the CPU takes the steps
  Uncollected uncollected_;
  std::string fallback_reason_;
};

}  // namespace hdrcam
