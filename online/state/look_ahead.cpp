#include "online/state/look_ahead.h"

#include "online/pictures/for_samples.h"
#include "online/pictures/warp.h"

namespace hdrcam {
namespace {

// The largest of each pixel and its left, upper and upper left neighbours, which may contribute to a warped
// pixel.
void dilate_2x2(const Image<float>& in, Image<float>& out, WorkerPool& pool) {
  out.reshape_like(in);
  pool.for_rows(in.rows(), [&](int y0, int y1) {
    for (int c = 0; c < in.channels(); ++c)
      for (int y = y0; y < y1; ++y) {
        const float *line = in.row(c, y), *above = in.row(c, std::max(0, y - 1));
        float* target = out.row(c, y);
        target[0] = std::max(line[0], above[0]);
        for (int x = 1; x < in.cols(); ++x)
          target[x] = std::max(std::max(line[x], line[x - 1]), std::max(above[x], above[x - 1]));
      }
  });
}

}  // namespace

void LookAhead::join(const RadianceState& state, std::span<const LaterFrame> later, Fusion& fusion,
                     JoinedState& joined) {
  copy(state.radiance, joined.radiance, pool_);
  copy(state.variance, joined.variance, pool_);
  copy(state.own_share, joined.own_share, pool_);
  joined.later_share.reshape(1, state.radiance.rows(), state.radiance.cols());
  joined.later_share.fill(0);
  if (later.empty()) return;
  const int rows = state.radiance.rows(), cols = state.radiance.cols();
  const BorrowedSamples room(pool_.scratch(), state.radiance, samples_);
  const Borrowed path(pool_.scratch(), rows, cols, {{&path_.vectors, 2}, {&path_.confidence, 1}});
  float intervals = 0;
  for (const LaterFrame& ahead : later) {
    intervals += 1;
    follow(*ahead.from_previous, intervals == 1);
    take_samples(ahead, fusion);
    const float fraction = ahead.frame->blur_fraction / intervals;  // of the path's time
    fusion.model_blur(joined, path_.confidence, path_.vectors, fraction, samples_);
    const Borrowed more(pool_.scratch(), rows, cols, {{&gate_, 1}, {&extra_, 3}, {&share_, 1}});
    fusion.gate(joined, samples_, *ahead.tables, path_.confidence, gate_, extra_);
    fusion.warp_variance(extra_, path_.vectors, extra_);
    fusion.update(joined, samples_, *ahead.tables, &gate_, &extra_, share_);
    for_samples(share_.size(), pool_, [&](std::size_t i0, std::size_t i1) {
      const float* share = share_.plane(0);
      float* total = joined.later_share.plane(0);
      for (std::size_t i = i0; i < i1; ++i) total[i] = total[i] * (1 - share[i]) + share[i];
    });
  }
}

// The samples of a later frame, at the pixels of the state's frame.
void LookAhead::take_samples(const LaterFrame& ahead, Fusion& fusion) {
  const Image<float>& codes = ahead.frame->codes;
  const Borrowed room(pool_.scratch(), codes.rows(), codes.cols(),
                      {{&codes_, 3}, {&brightest_, 3}, {&dilated_, 3}});
  warp_cubic(codes, path_.vectors, 0, codes_, pool_);
  dilate_2x2(codes, dilated_, pool_);
  warp_linear(dilated_, path_.vectors, brightest_, pool_);
  fusion.sample(codes_, brightest_, *ahead.tables, samples_);
}

// Lengthens the path by one interval: flows are chained, confidences multiplied.
void LookAhead::follow(const FlowField& from_previous, bool nearest) {
  if (nearest) {
    copy(from_previous.vectors, path_.vectors, pool_);
    copy(from_previous.confidence, path_.confidence, pool_);
    return;
  }
  const Borrowed room(pool_.scratch(), path_.vectors.rows(), path_.vectors.cols(), {{&warped_, 2}});
  warp_linear(from_previous.confidence, path_.vectors, warped_, pool_);
  for (std::size_t i = 0; i < warped_.size(); ++i) path_.confidence.samples()[i] *= warped_.samples()[i];
  warp_linear(from_previous.vectors, path_.vectors, warped_, pool_);
  for (std::size_t i = 0; i < warped_.size(); ++i) path_.vectors.samples()[i] += warped_.samples()[i];
}

}  // namespace hdrcam
