// The fit of the window's field to the stream: observe() takes the next frame into the window, step() takes
// one Adam step on a few hundred rays. The field starts from the state's picture (window.h), so it can be
// rendered after any number of steps, also none. Deterministic: the same frames and seed give the same bytes
// for any number of threads. No allocation after the first frame. Thread-bound.
#pragma once

#include "hal/core/worker_pool.h"
#include "online/scene/fit_budget.h"
#include "online/scene/hash_grid/field/field_probe.h"
#include "online/scene/hash_grid/fit/field_options.h"
#include "online/scene/hash_grid/fit/fit_health.h"
#include "online/scene/hash_grid/fit/ray_shard.h"

namespace hdrcam {

struct StepReport {
  LossValues<double> losses{};  // weighted, by LossTerm
  double total = 0;             // their sum
  double gradient_norm = 0;     // of network weights and grid features
  StepVerdict verdict = StepVerdict::Taken;
};

class FieldFit {
 public:
  FieldFit(const FieldOptions& options, const Intrinsics& camera, int rows, int cols, WorkerPool& pool);

  // response: the estimate at this frame; ignored once the fit refines its own. Errors: Invalid, BadExposure
  // (window.h); the field is then unchanged.
  Result<void> observe(const FieldObservation& seen, const Response& response);
  // Forgets all frames and what was fitted to them; what is known of the response stays.
  void restart();
  // Sets the budget of the next steps and of rendering.
  void prepare(const FitBudget& budget);
  // Takes one step. Needs a frame; with an empty window it does nothing.
  StepReport step();

  RadianceField field() const { return {window_, networks_, samples_per_ray_, has_dynamic_}; }
  Window& window() { return window_; }
  // Reinitialises the networks, with the same shape.
  FieldNetworks<float> fresh_networks(std::uint64_t seed) const;
  const FitCounts& counts() const { return health_.counts(); }
  const FieldOptions& options() const { return options_; }
  const LearnedResponse<float>& response() const { return response_; }

 private:
  static constexpr int kRaysPerShard = 32;

  struct Optimised {  // a branch's parameters with Adam's moments
    Branch<float>& branch;
    AdamMoments network;
    Image<float> table_mean, table_variance;
    std::vector<float> d_network;
    Image<float> kept_tables;  // last good copy
    std::vector<float> kept_network;

    explicit Optimised(Branch<float>& b);
    void keep();
    void restore();
  };

  std::span<RayShard<float>> shards() { return {shards_.data(), rays_.size() / kRaysPerShard}; }
  void make_ready();
  void draw_rays();
  TrainingRay ray_at(int frame, int x, int y);
  void aim_at_neighbour(TrainingRay& ray);
  double reduce(StepReport& report);
  void apply(float gradient_scale);
  void apply_response(float gradient_scale);
  void refresh_guide();
  void reanchor();
  void start_networks();

  FieldOptions options_;
  WorkerPool& pool_;
  Pcg32 random_;
  Window window_;
  FieldNetworks<float> networks_;
  FitBudget budget_;
  int samples_per_ray_ = 0;
  bool has_dynamic_ = true;  // false where nothing in the window moves
  LearnedResponse<float> response_;
  Optimised still_, moving_;
  std::vector<RayShard<float>> shards_;  // as many as the largest budget so far needed; shards() are in use
  int most_samples_ = 0;                 // capacity of a shard
  std::vector<PixelPicker> pickers_;     // by slot
  std::vector<TrainingRay> rays_;
  std::vector<float> table_before_;  // when the anchor moves
  FieldProbe probe_;
  LearnedResponse<float>::Gradient d_response_{};
  AdamMoments response_moments_;
  FitHealth health_;
  long taken_ = 0;  // Adam steps
  bool response_started_ = false;
  bool ready_ = false;  // for steps on the newest frame
};

}  // namespace hdrcam
