#include "render/emission.h"

#include <cmath>

#include "online/state/local_statistics.h"
#include "online/state/warp.h"

namespace hdrcam {
namespace {

// The largest of each pixel and its left, upper and upper left neighbours: what may have gone into a warped
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

void Emission::render(const Moment& moment, HdrFrame& frame) {
  join(moment);
  conclude(moment, frame);
}

void Emission::join(const Moment& moment) {
  Fusion& fusion = *moment.fusion;
  merged_.copy_from(*moment.state);
  const int rows = merged_.radiance.rows(), cols = merged_.radiance.cols();
  ahead_share_.reshape(1, rows, cols);
  ahead_share_.fill(0);

  float steps = 0;
  for (const Moment::Ahead& ahead : moment.ahead) {
    steps += 1;
    if (steps == 1) {
      path_.vectors.copy_from(ahead.from_previous->vectors);
      path_.confidence.copy_from(ahead.from_previous->confidence);
    } else {
      warp_linear(ahead.from_previous->confidence, path_.vectors, warped_, pool_);
      for (std::size_t i = 0; i < warped_.size(); ++i) path_.confidence.samples()[i] *= warped_.samples()[i];
      warp_linear(ahead.from_previous->vectors, path_.vectors, warped_, pool_);
      for (std::size_t i = 0; i < warped_.size(); ++i) path_.vectors.samples()[i] += warped_.samples()[i];
    }
    warp_cubic(ahead.frame->codes, path_.vectors, 0, codes_, pool_);
    dilate_2x2(ahead.frame->codes, dilated_, pool_);
    warp_linear(dilated_, path_.vectors, brightest_, pool_);
    fusion.sample(codes_, brightest_, *ahead.tables, samples_);
    fusion.gate(merged_, samples_, *ahead.tables, path_.confidence, gate_);
    local_contrast(merged_.radiance, mean_, contrast_, pool_);
    fusion.warp_variance(contrast_, path_.vectors, extra_);
    flow_.copy_from(path_.vectors);  // per interval
    for (float& v : flow_.samples()) v /= steps;
    fusion.update(merged_, samples_, *ahead.tables, flow_, ahead.frame->blur_fraction, &gate_, &extra_,
                  share_);
    for (std::size_t i = 0; i < share_.size(); ++i) {
      float& total = ahead_share_.samples()[i];
      total = total * (1 - share_.samples()[i]) + share_.samples()[i];
    }
  }
}

void Emission::conclude(const Moment& moment, HdrFrame& frame) {
  constexpr float kDarkOffset =
      1 / 5000.f;  // of white: below it differences are not visible after mu-law, mu = 5000
  const int rows = merged_.radiance.rows(), cols = merged_.radiance.cols();
  const float known = known_limit(moment.white), offset = moment.white * kDarkOffset;

  frame.facts = moment.frame->facts;
  frame.exposure = moment.frame->exposure;
  frame.reference_exposure = moment.reference_exposure;
  frame.white = moment.white;
  frame.sigma.reshape(1, rows, cols);
  frame.provenance.reshape(1, rows, cols);
  pool_.for_rows(rows, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y)
      for (int x = 0; x < cols; ++x) {
        float worst = 0, relative = 0;
        for (int c = 0; c < 3; ++c) {
          const float r = merged_.radiance.at(c, y, x) + offset, v = merged_.variance.at(c, y, x);
          worst = std::max(worst, v);
          relative += v / (r * r) * (1 / 3.f);
        }
        const float later = ahead_share_.at(0, y, x), own = merged_.own_share.at(0, y, x) * (1 - later);
        Provenance from = Provenance::Carried;
        if (worst >= known)
          from = Provenance::Bound;
        else if (later > 0.5f)
          from = Provenance::LookAhead;
        else if (own > 0.5f)
          from = Provenance::Own;
        frame.provenance.at(0, y, x) = static_cast<std::uint8_t>(from);
        frame.sigma.at(0, y, x) = std::min(10.f, std::sqrt(relative));
      }
  });
  if (options_.shrinkage == ShrinkageMode::On) shrinkage_.apply(merged_.radiance, merged_.variance, offset);
  frame.radiance.copy_from(merged_.radiance);
  if (moment.to_previous != nullptr)
    frame.flow.copy_from(moment.to_previous->vectors);
  else
    frame.flow.reshape(0, 0, 0);
}

}  // namespace hdrcam
