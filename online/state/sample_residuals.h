// Measures how far samples are from the state's prediction, by exposure, channel and code: an independent
// check of the noise and response models. Where spread or a steady offset exceeds the predicted variance, the
// excess is added to the variance of such samples until it vanishes. Only matched, smooth, unclipped pixels
// are used. Thread-bound.
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

  // predicted: the state carried to the frame, before its samples are fused. white: as for
  // known_limit().
  void observe(const RadianceState& predicted, const Samples& samples, const Image<float>& confidence,
               const ExposureTables& tables, float white);

  // The excess variance of this exposure so far; zero at first.
  const VarianceExcess& excess(float exposure) const;

 private:
  static int slot_of(float exposure);

  // From the current frame: at most kCapacity of its pixels, picked evenly.
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
