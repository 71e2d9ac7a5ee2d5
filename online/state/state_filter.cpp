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
  const BorrowedSamples room(pool_.scratch(), frame.codes, samples_);
  fusion_.sample(frame.codes, frame.codes, tables, samples_);
  state_.radiance.copy_from(samples_.radiance);
  state_.variance.fill(kUnseenVariance);
  fusion_.update(state_, samples_, tables, nullptr, nullptr, state_.own_share);
}

void StateFilter::advance(const ExposedFrame& frame, const ExposureTables& tables,
                          const FlowField& to_previous) {
  const BorrowedSamples room(pool_.scratch(), frame.codes, samples_);
  const Borrowed more(pool_.scratch(), frame.codes.rows(), frame.codes.cols(),
                      {{&predicted_.radiance, 3}, {&predicted_.variance, 3}, {&predicted_.own_share, 1}});
  fusion_.sample(frame.codes, frame.codes, tables, samples_);
  predict(to_previous, frame.blur_fraction, tables);
  residuals_.observe(predicted_, samples_, to_previous.confidence, tables, fusion_.white(), pool_);
  std::swap(state_, predicted_);  // the memory of the old state is what is given back
  fusion_.update(state_, samples_, tables, nullptr, nullptr, state_.own_share);
}

void StateFilter::predict(const FlowField& to_previous, float blur_fraction, const ExposureTables& tables) {
  const Image<float>& flow = to_previous.vectors;
  warp_cubic(state_.radiance, flow, options_.ringing_limit, predicted_.radiance, pool_);
  warp_linear(state_.variance, flow, predicted_.variance, pool_);
  fusion_.model_blur(predicted_, to_previous.confidence, flow, blur_fraction, samples_);
  const Borrowed room(pool_.scratch(), flow.rows(), flow.cols(), {{&gate_, 1}, {&added_, 3}});
  fusion_.gate(predicted_, samples_, tables, to_previous.confidence, gate_, added_);
  fusion_.warp_variance(added_, flow, added_);

  const float growth = 1 + options_.variance_growth,
              relative2 = options_.relative_growth * options_.relative_growth;
  const int cols = flow.cols();
  pool_.for_rows(flow.rows(), [&](int y0, int y1) {
    for (int c = 0; c < 3; ++c)
      for (int y = y0; y < y1; ++y) {
        const float *s = predicted_.radiance.row(c, y), *added = added_.row(c, y), *gate = gate_.row(0, y);
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
