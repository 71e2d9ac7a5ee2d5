#include "online/state/state_filter.h"

#include "online/pictures/warp.h"
#include "online/state/fusion_kernels.h"

namespace hdrcam {

StateFilter::StateFilter(StateOptions options, int rows, int cols, WorkerPool& pool)
    : options_(options), pool_(pool), fusion_(options.fusion, pool) {
  state_.radiance = Image<float>(3, rows, cols);
  state_.variance = Image<float>(3, rows, cols);
  state_.own_share = Image<float>(1, rows, cols);
}

void StateFilter::restart(const StateInput& input) {
  const auto& [frame, tables, unseen_variance, blurs] = input;
  const int rows = frame.codes.rows(), cols = frame.codes.cols();
  const SamplesLease room(pool_.scratch(), frame.codes, samples_);
  const ScratchLease more(pool_.scratch(), rows, cols,
                          {{&predicted_.radiance, 3}, {&predicted_.variance, 3}});
  residuals_ = SampleResiduals();
  fusion_.sample(frame.codes, frame.codes, tables, samples_);
  predicted_.radiance.copy_from(samples_.radiance);
  predicted_.variance.fill(kUnseenVariance);
  fusion_.update({predicted_, samples_, tables, unseen_variance}, nullptr, nullptr, state_, state_.own_share,
                 SampleOrder::FirstFrame);
}

void StateFilter::advance(const StateInput& input, const FlowField& to_previous) {
  const auto& [frame, tables, unseen_variance, blurs] = input;
  const int rows = frame.codes.rows(), cols = frame.codes.cols();
  const SamplesLease room(pool_.scratch(), frame.codes, samples_);
  const ScratchLease more(pool_.scratch(), rows, cols,
                          {{&predicted_.radiance, 3}, {&predicted_.variance, 3}});
  fusion_.sample(frame.codes, frame.codes, tables, samples_);
  predict(input, to_previous);
  const Seen seen{predicted_, samples_, tables, unseen_variance};
  residuals_.observe(seen, to_previous.confidence, pool_);
  fusion_.update(seen, nullptr, nullptr, state_, state_.own_share);
}

void StateFilter::predict(const StateInput& input, const FlowField& to_previous) {
  const Image<float>& flow = to_previous.vectors;
  const int rows = flow.rows(), cols = flow.cols();
  warp_radiance(state_.radiance, flow, predicted_.radiance, pool_);
  warp_linear(state_.variance, flow, predicted_.variance, pool_);
  fusion_.model_blur(predicted_, flow, input.blur_fraction(), samples_);
  const ScratchLease room(pool_.scratch(), rows, cols, {{&gate_, 1}, {&contrast_, 3}});
  const ScratchLease lines(pool_.scratch(), WorkerPool::bands_of(rows), cols, {{&per_contrast_, 1}});
  fusion_.gate({predicted_, samples_, input.tables, input.unseen_variance}, to_previous.confidence, gate_,
               contrast_);

  pool_.for_rows_of_bands(rows, [&](int band, int y) {
    float* per_contrast = per_contrast_.row(0, band);
    fusion_.warp_variance(flow, y, per_contrast);
    for (int c = 0; c < 3; ++c)
      fusion_kernels().age({.state = predicted_.radiance.row(c, y),
                            .variance = predicted_.variance.row(c, y),
                            .gate = gate_.row(0, y),
                            .sample = samples_.radiance.row(c, y),
                            .weight = samples_.weight.row(c, y),
                            .contrast = contrast_.row(c, y),
                            .per_contrast = per_contrast,
                            .growth = 1 + options_.variance_growth,
                            .relative2 = options_.relative_growth * options_.relative_growth,
                            .floor = options_.fusion.gate_floor,
                            .unseen_from = input.unseen_variance,
                            .lost_variance = kUnseenVariance,
                            .least = input.tables.least_radiance(c),
                            .new_variance = predicted_.variance.row(c, y)},
                           cols);
  });
}

}  // namespace hdrcam
