#include "render/emission.h"

#include <algorithm>
#include <cmath>

#include "online/mu_law.h"
#include "render/black_channels.h"
#include "render/channel_rows.h"

namespace hdrcam {
namespace {

constexpr float kMostSigma = 10;  // of ln radiance: more says no more, and unseen pixels have far more

constexpr int code(Provenance from) { return static_cast<int>(from); }

}  // namespace

void Emission::render(const FrameEstimate& estimate, HdrFrame& frame) {
  const float offset = barely_visible(estimate.white);
  frame.facts = estimate.frame.facts;
  frame.exposure = static_cast<float>(frame.facts.exposure() / estimate.reference_exposure);  // as stated
  frame.reference_exposure = estimate.reference_exposure;
  frame.white = estimate.white;
  frame.neutral_gains = estimate.neutral_gains;
  frame.white_balance.reset();
  frame.pose = estimate.pose;
  frame.length_unit = estimate.length_unit;
  frame.lens = estimate.view.lens;
  frame.lens_is_assumed = estimate.lens_is_assumed;
  judge(estimate, offset, frame);
  colour_black_channels({estimate.darkest, estimate.unseen_variance, offset}, estimate.state, frame.radiance,
                        pool_);
  shrinkage_.apply(frame.radiance, estimate.state.variance,
                   {offset, estimate.noise_origin, estimate.budget.shrinkage});
}

// The source of each pixel and its uncertainty.
void Emission::judge(const FrameEstimate& estimate, float offset, HdrFrame& frame) {
  const RadianceEstimate& state = estimate.state;
  const int rows = state.radiance.rows(), cols = state.radiance.cols();
  const float unseen_from = estimate.unseen_variance;  // a copy: bytes are written, which may be anything
  frame.sigma.reshape(1, rows, cols);
  frame.provenance.reshape(1, rows, cols);
  pool_.for_rows(rows, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      const auto radiance = rows_of(state.radiance, y), variance = rows_of(state.variance, y);
      const float* own = estimate.own_share.row(0, y);
      const float* later = estimate.later_share != nullptr ? estimate.later_share->row(0, y) : nullptr;
      float* sigma = frame.sigma.row(0, y);
      std::uint8_t* provenance = frame.provenance.row(0, y);
      for (int x = 0; x < cols; ++x) {
        float relative = 0;
        for (std::size_t c = 0; c < 3; ++c) {
          const float r = radiance[c][x] + offset, v = variance[c][x];
          relative += v / (r * r) * (1 / 3.f);
        }
        sigma[x] = std::min(kMostSigma, std::sqrt(relative));
      }
      for (int x = 0; x < cols; ++x) {  // without branches, so that it becomes vectors
        const float worst = std::max(std::max(std::max(0.f, variance[0][x]), variance[1][x]), variance[2][x]);
        const float joined = later != nullptr ? later[x] : 0;
        int from = own[x] * (1 - joined) > 0.5f ? code(Provenance::Own) : code(Provenance::Carried);
        from = joined > 0.5f ? code(Provenance::LookAhead) : from;
        from = worst >= unseen_from ? code(Provenance::Bound) : from;
        provenance[x] = static_cast<std::uint8_t>(from);
      }
    }
  });
}

}  // namespace hdrcam
