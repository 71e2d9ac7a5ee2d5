// The sensor's noise, measured while the stream runs: pairs of neighbouring frames, matched by the flow,
// compared in smooth places. In each bin of brightness the median of the squared difference gives a variance;
// shot and read noise are the non-negative line through the bins (relative least squares), with a code-domain
// term for what a codec did tried beside them. Thread-bound.
#pragma once

#include <array>
#include <map>
#include <vector>

#include "capture/exposed_frame.h"
#include "capture/noise_model.h"
#include "hal/core/worker_pool.h"
#include "online/pictures/flow_field.h"
#include "online/response/response.h"

namespace hdrcam {

class NoiseEstimator {
 public:
  explicit NoiseEstimator(WorkerPool& pool) : pool_(pool) {
    constexpr std::size_t kUsualRatios = 16;
    sorted_.reserve(Bin::kCapacity);
    equations_.reserve(kUsualRatios * kBrightnesses);
  }

  // a -> b: flow from frame a's pixels into frame b. The shorter exposure must be `a`: its noise is the
  // larger, and interpolating b halves only the smaller.
  void add_pair(const ExposedFrame& a, const ExposedFrame& b, const FlowField& a_to_b,
                const Response& response);

  // The model that fits what was seen; `otherwise` where too little was. code_noise and code_step are taken
  // from `otherwise`: what a codec does sits at edges, where this estimator does not look.
  NoiseModel solve(const NoiseModel& otherwise);

 private:
  // One bin of brightness at one exposure ratio; the newest kCapacity differences are kept. All bins of a
  // ratio are made when it is first seen, so that a scene that brightens later takes no memory.
  struct Bin {
    static constexpr std::size_t kCapacity = 4096;
    std::vector<float> squares;
    std::size_t next = 0;
    double count = 0, exposure_sum = 0, slope2_sum = 0, ratio = 1;
    Bin() { squares.reserve(kCapacity); }
    void add(float square, float x, float slope2);
  };

  WorkerPool& pool_;
  // What one bin says: variance = shot * shot_factor + read * read_factor + slope2 * code variance.
  struct Equation {
    double shot_factor, read_factor, slope2, variance, weight;
  };

  static constexpr int kBrightnesses = 28;  // half stops below full exposure

  std::map<int, std::array<Bin, kBrightnesses>> bins_;  // by quarter stops of exposure ratio
  Image<float> warped_, warped_mean_, mean_;
  std::vector<Equation> equations_;  // of the last solve()
  std::vector<float> sorted_;
};

}  // namespace hdrcam
