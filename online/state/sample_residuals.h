// How far samples are from what the state predicted of them, by exposure, channel and code: the check that no
// model of noise or response makes for itself. What exceeds the predicted variance, as spread or as a steady
// offset, is variance that samples of that kind have too much of; it is added to theirs until it is gone.
// Looked at are matched, smooth, unclipped pixels only. Thread-bound.
#pragma once

#include <array>
#include <map>
#include <vector>

#include "online/state/exposure_tables.h"
#include "online/state/fusion.h"
#include "online/state/radiance_state.h"

namespace hdrcam {

class SampleResiduals {
 public:
  SampleResiduals();

  // predicted: the state carried to the frame, before its samples are in it. white: as known_limit() takes
  // it.
  void observe(const RadianceState& predicted, const Samples& samples, const Image<float>& confidence,
               const ExposureTables& tables, float white);

  // What samples of this exposure have shown so far; zero at first.
  const VarianceExcess& excess(float exposure) const;

 private:
  static int slot_of(float exposure);

  // Of the frame at hand: at most kCapacity of its pixels, picked evenly.
  struct Bin {
    static constexpr std::size_t kCapacity = 2048;
    std::vector<float> residuals, predicted;  // relative exposure; variance of it by noise and response alone
    std::size_t seen = 0;
    void add(float residual, float variance);
  };
  std::array<std::array<Bin, VarianceExcess::kBins>, 3> bins_;
  std::map<int, VarianceExcess> excess_;  // by half stops of exposure
};

}  // namespace hdrcam
