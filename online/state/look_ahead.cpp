#include "online/state/look_ahead.h"

#include "online/pictures/for_samples.h"
#include "online/pictures/warp.h"

namespace hdrcam {

void LookAhead::join(const RadianceEstimate& state, std::span<const LaterFrame> later, float unseen_variance,
                     Fusion& fusion, JoinedState& joined) {
  HDRCAM_CHECK(!later.empty());
  const int rows = state.radiance.rows(), cols = state.radiance.cols();
  const SamplesLease room(pool_.scratch(), state.radiance, samples_);
  const int rows_of_more = later.size() > 1 ? rows : 0;  // what only more than one later frame needs
  const ScratchLease for_more(pool_.scratch(), rows_of_more, cols,
                              {{&path_.vectors, 2},
                               {&path_.confidence, 1},
                               {&between_.radiance, 3},
                               {&between_.variance, 3},
                               {&share_, 1}});
  const RadianceEstimate* before = &state;
  const FlowField* path = later[0].from_previous;
  for (std::size_t i = 0; i < later.size(); ++i) {
    const LaterFrame& ahead = later[i];
    if (i > 0) path = &lengthened(*path, *ahead.from_previous);
    take_samples(ahead, path->vectors, fusion);
    fusion.model_blur(*before, path->vectors, blur_of_path(later.first(i + 1)), samples_);
    const ScratchLease more(pool_.scratch(), rows, cols, {{&gate_, 1}, {&contrast_, 3}});
    const Seen seen{*before, samples_, *ahead.tables, unseen_variance};
    fusion.gate(seen, path->confidence, gate_, contrast_);
    // by turns, so that the last one is what is asked for
    RadianceEstimate& after = (later.size() - i) % 2 == 1 ? joined : between_;
    const Moved moved{contrast_, path->vectors, static_cast<int>(i) + 1, ahead.shorter};
    fusion.update(seen, &gate_, &moved, after, i == 0 ? joined.later_share : share_);
    before = &after;
    if (i == 0) continue;
    for_samples(share_, pool_, [&](std::size_t i0, std::size_t i1) {
      const float* share = share_.plane(0);
      float* total = joined.later_share.plane(0);
      for (std::size_t k = i0; k < i1; ++k) total[k] = total[k] * (1 - share[k]) + share[k];
    });
  }
}

// The samples of a later frame, at the pixels of the state's frame.
void LookAhead::take_samples(const LaterFrame& ahead, const Image<float>& path, Fusion& fusion) {
  const Image<float>& codes = ahead.frame->codes;
  const ScratchLease room(pool_.scratch(), codes.rows(), codes.cols(), {{&brightest_, 3}});
  Image<float>& warped = samples_.blur;  // its memory is idle until the blur is modelled
  warp_cubic_and_largest(codes, path, warped, brightest_, pool_);
  fusion.sample(warped, brightest_, *ahead.tables, samples_);
}

// A path and the interval after it: flows are chained, confidences multiplied. The path may be the one that
// is returned.
const FlowField& LookAhead::lengthened(const FlowField& path, const FlowField& next) {
  const int rows = path.vectors.rows(), cols = path.vectors.cols();
  const ScratchLease room(pool_.scratch(), rows, cols, {{&onward_, 2}, {&trust_, 1}});
  warp_linear(next.vectors, path.vectors, onward_, pool_);
  warp_linear(next.confidence, path.vectors, trust_, pool_);
  path_.vectors.reshape(2, rows, cols), path_.confidence.reshape(1, rows, cols);
  const auto join = [&](const Image<float>& before, const Image<float>& after, Image<float>& both,
                        auto&& op) {
    for_samples(both, pool_, [&, op](std::size_t i0, std::size_t i1) {
      const float *a = before.plane(0), *b = after.plane(0);
      float* out = both.plane(0);
      for (std::size_t i = i0; i < i1; ++i) out[i] = op(a[i], b[i]);
    });
  };
  join(path.vectors, onward_, path_.vectors, [](float a, float b) { return a + b; });
  join(path.confidence, trust_, path_.confidence, [](float a, float b) { return a * b; });
  return path_;
}

}  // namespace hdrcam
