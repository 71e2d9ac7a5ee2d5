#include "online/state/look_ahead.h"

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
  joined.copy_from(state);
  joined.later_share.reshape(1, state.radiance.rows(), state.radiance.cols());
  joined.later_share.fill(0);
  float intervals = 0;
  for (const LaterFrame& ahead : later) {
    intervals += 1;
    follow(*ahead.from_previous, intervals == 1);
    warp_cubic(ahead.frame->codes, path_.vectors, 0, codes_, pool_);
    dilate_2x2(ahead.frame->codes, dilated_, pool_);
    warp_linear(dilated_, path_.vectors, brightest_, pool_);
    fusion.sample(codes_, brightest_, *ahead.tables, samples_);
    const float fraction = ahead.frame->blur_fraction / intervals;  // of the path's time
    fusion.model_blur(joined, path_.confidence, path_.vectors, fraction, samples_);
    fusion.gate(joined, samples_, *ahead.tables, path_.confidence, gate_);
    fusion.warp_variance(fusion.contrast(), path_.vectors, extra_);
    fusion.update(joined, samples_, *ahead.tables, &gate_, &extra_, share_);
    for (std::size_t i = 0; i < share_.size(); ++i) {
      float& total = joined.later_share.samples()[i];
      total = total * (1 - share_.samples()[i]) + share_.samples()[i];
    }
  }
}

// Lengthens the path by one interval: flows are chained, confidences multiplied.
void LookAhead::follow(const FlowField& from_previous, bool nearest) {
  if (nearest) {
    path_.vectors.copy_from(from_previous.vectors);
    path_.confidence.copy_from(from_previous.confidence);
    return;
  }
  warp_linear(from_previous.confidence, path_.vectors, warped_, pool_);
  for (std::size_t i = 0; i < warped_.size(); ++i) path_.confidence.samples()[i] *= warped_.samples()[i];
  warp_linear(from_previous.vectors, path_.vectors, warped_, pool_);
  for (std::size_t i = 0; i < warped_.size(); ++i) path_.vectors.samples()[i] += warped_.samples()[i];
}

}  // namespace hdrcam
