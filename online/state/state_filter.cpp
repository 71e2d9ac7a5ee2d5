#include "online/state/state_filter.h"

#include "online/pictures/warp.h"

namespace hdrcam {

StateFilter::StateFilter(StateOptions options, int rows, int cols, WorkerPool& pool)
    : options_(options), pool_(pool), fusion_(options.fusion, pool) {
  state_.radiance = Image<float>(3, rows, cols);
  state_.variance = Image<float>(3, rows, cols);
  state_.own_share = Image<float>(1, rows, cols);
}

void StateFilter::restart(const ExposedFrame& frame, const ExposureTables& tables) {
  const int rows = frame.codes.rows(), cols = frame.codes.cols();
  const BorrowedSamples room(pool_.scratch(), frame.codes, samples_);
  const Borrowed more(pool_.scratch(), rows, cols, {{&predicted_.radiance, 3}, {&predicted_.variance, 3}});
  fusion_.sample(frame.codes, frame.codes, tables, samples_);
  predicted_.radiance.copy_from(samples_.radiance);
  predicted_.variance.fill(kUnseenVariance);
  fusion_.update(predicted_, samples_, tables, nullptr, nullptr, state_, state_.own_share);
}

void StateFilter::advance(const ExposedFrame& frame, const ExposureTables& tables,
                          const FlowField& to_previous) {
  const int rows = frame.codes.rows(), cols = frame.codes.cols();
  const BorrowedSamples room(pool_.scratch(), frame.codes, samples_);
  const Borrowed more(pool_.scratch(), rows, cols, {{&predicted_.radiance, 3}, {&predicted_.variance, 3}});
  fusion_.sample(frame.codes, frame.codes, tables, samples_);
  predict(to_previous, frame.blur_fraction, tables);
  residuals_.observe(predicted_, samples_, to_previous.confidence, tables, fusion_.white(), pool_);
  fusion_.update(predicted_, samples_, tables, nullptr, nullptr, state_, state_.own_share);
}

void StateFilter::predict(const FlowField& to_previous, float blur_fraction, const ExposureTables& tables) {
  const Image<float>& flow = to_previous.vectors;
  const int rows = flow.rows(), cols = flow.cols();
  warp_cubic(state_.radiance, flow, options_.ringing_limit, predicted_.radiance, pool_);
  warp_linear(state_.variance, flow, predicted_.variance, pool_);
  fusion_.model_blur(predicted_, to_previous.confidence, flow, blur_fraction, samples_);
  const Borrowed room(pool_.scratch(), rows, cols, {{&gate_, 1}, {&contrast_, 3}, {&added_, 1}});
  fusion_.gate(predicted_, samples_, tables, to_previous.confidence, gate_, contrast_);

  const float growth = 1 + options_.variance_growth,
              relative2 = options_.relative_growth * options_.relative_growth;
  pool_.for_rows(rows, [&](int y0, int y1) {
    float* added = added_.row(0, y0);  // a line for each band
    for (int c = 0; c < 3; ++c)
      for (int y = y0; y < y1; ++y) {
        fusion_.warp_variance({contrast_, flow}, c, y, added);
        const float *s = predicted_.radiance.row(c, y), *gate = gate_.row(0, y);
        float* v = predicted_.variance.row(c, y);
        for (int x = 0; x < cols; ++x) {
          const float carried =
              (v[x] * growth + relative2 * s[x] * s[x] + added[x]) / std::max(1e-4f, gate[x]);
          const bool lost = gate[x] < options_.fusion.gate_floor || !(carried < kUnseenVariance);
          v[x] = lost ? kUnseenVariance : carried;
        }
      }
  });
}

}  // namespace hdrcam
