// Measures the sensor's noise while the stream runs: it compares pairs of neighbouring frames, matched by the
// flow, in smooth places. In each bin of brightness the spread of the differences around their own centre
// gives a variance, so that a response error, which moves the centre, does not count as noise. Shot, read and
// code-domain noise (and a term proportional to the light for imperfect matches) are solved together, at the
// gain of the clip's first frame, as the most probable values under a prior from typical cameras: where the
// bins cannot separate them the prior does, and no value ends at a limit. Thread-bound.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <vector>

#include "capture/exposed_frame.h"
#include "capture/noise_model.h"
#include "hal/core/worker_pool.h"
#include "online/pictures/flow_field.h"
#include "online/response/response.h"

namespace hdrcam {

// Gains of two frames, over that of the clip's first frame.
struct PairGains {
  float a, b;
};

class NoiseEstimator {
 public:
  explicit NoiseEstimator(WorkerPool& pool) : pool_(pool) {
    constexpr std::size_t kUsualRatios = 16;
    for (std::vector<float>& share : sorted_) share.reserve(Bin::kCapacity);
    telling_.reserve(kUsualRatios * kBrightnesses), equations_.reserve(kUsualRatios * kBrightnesses);
  }

  // a -> b: flow from frame a's pixels into frame b. The shorter exposure must be `a`: its noise is larger,
  // and b measures a pixel's brightness more precisely.
  void add_pair(const ExposedFrame& a, const ExposedFrame& b, const FlowField& a_to_b,
                const Response& response, PairGains gains = {1, 1});

  long pairs() const { return pairs_; }

  // What single frames show of the sensor's own noise: the mean of a narrower prior.
  void expect(const NoiseModel& seen) { seen_ = seen; }

  // The most probable model; where there are too few samples what was seen, else `otherwise`. code_step is
  // taken from `otherwise`; the code_noise of what was seen, or of `otherwise`, is the mean of the prior of
  // the code-domain noise.
  NoiseModel solve(const NoiseModel& otherwise);

 private:
  // variance = shot * factor of shot + read * factor of read + .., in relative exposure squared
  template <class Number>
  struct Factors {
    Number shot, read, code, relative;
  };
  // One bin of brightness at one exposure ratio; it keeps the newest kCapacity differences and the factors of
  // each, which go by its gains. All bins of a ratio are allocated when it first occurs, so that a scene that
  // brightens later allocates nothing.
  struct Bin {
    static constexpr std::size_t kCapacity = 4096;
    std::vector<float> differences;  // apart from their factors: their spread is found by sorting a copy
    std::vector<Factors<float>> factors;
    std::size_t next = 0;
    Bin() { differences.reserve(kCapacity), factors.reserve(kCapacity); }
    void add(float difference, const Factors<float>& its) {
      if (differences.size() < kCapacity)
        differences.push_back(difference), factors.push_back(its);
      else
        differences[next] = difference, factors[next] = its, next = (next + 1) % kCapacity;
    }
  };
  // The equation of one bin, with the mean of its factors and an uncertainty of `sigma` in ln.
  struct Equation {
    Factors<double> factors;
    double variance, sigma;
  };
  enum Compared : int;
  void compare_stripes(const ExposedFrame& a, const ExposedFrame& b, const FlowField& a_to_b,
                       const Response& response, float ratio);
  void sort_into_bins(float ratio, PairGains gains);
  int compare_row(const ExposedFrame& a, const FlowField& a_to_b, const Response& response, float ratio,
                  int row);
  static Equation equation_of(const Bin& bin, std::vector<float>& sorted);
  void collect_equations();

  static constexpr int kBrightnesses = 27;  // half stops below full exposure

  WorkerPool& pool_;
  long pairs_ = 0;
  std::map<int, std::array<Bin, kBrightnesses>> bins_;  // by quarter stops of exposure ratio
  Image<float> warped_, warped_mean_, compared_;        // borrowed during a call
  std::vector<int> found_;                              // by row of compared_
  std::optional<NoiseModel> seen_;                      // by expect()
  // of the last solve()
  std::vector<const Bin*> telling_;  // those with samples enough
  std::vector<Equation> equations_;  // one each
  static constexpr std::size_t kShares = 4;
  std::array<std::vector<float>, kShares> sorted_;  // each for a share of the bins
};

}  // namespace hdrcam
