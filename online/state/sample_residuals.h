// Measures how far samples are from the state's prediction, by exposure, channel and code: an independent
// check of the noise and response models. Where spread or a steady offset exceeds the predicted variance, the
// excess is added to the variance of such samples until it vanishes. Only matched, smooth, unclipped pixels
// are used. Thread-bound.
#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <vector>

#include "online/pictures/flow_field.h"
#include "online/state/exposure_tables.h"
#include "online/state/fusion.h"

namespace hdrcam {

// Which pixels are looked at.
struct ResidualSampling {
  int stride_px = 2;  // the first at (1, 1), none in the last row and column
  float least_confidence = kComparedConfidence;
  float misalignment = 0.05f;  // squared pixels per (2 pixels)^2: what a match may be off
  float relative = 0.05f;      // of radiance: contrast that does no harm
  int enough_px = 9600;        // of a frame of any size; by ablation (docs/decisions/kernels.md)

  // Between lines that are looked at.
  int line_step_px(int rows, int cols) const {
    return stride_px * std::max(1, rows * cols / (stride_px * stride_px) / enough_px);
  }
  // How many lines of a picture of at least 3x3 pixels are looked at, and how many pixels of each.
  int lines(int rows, int cols) const {
    const int step = line_step_px(rows, cols);
    return (rows - 2 + step - 1) / step;
  }
  int pixels_of_line(int cols) const { return (cols - 2 + stride_px - 1) / stride_px; }
};
inline constexpr ResidualSampling kResidualSampling;

class SampleResiduals {
 public:
  SampleResiduals();

  // predicted: the state carried to the frame, before its samples are fused. confidence: [1, rows, cols] of
  // the flow along which it was carried.
  void observe(const Seen& predicted, const Image<float>& confidence, WorkerPool& pool);

  // The same in three steps, for callers that select the pixels themselves (kResidualSampling): start a
  // frame, add each selected pixel in a fixed order, learn the frame's excess.
  void begin();
  void take(int channel, int bin, float residual, float variance) {
    bins_[static_cast<std::size_t>(channel)][static_cast<std::size_t>(bin)].add(residual, variance);
  }
  void learn(float exposure);

  // The excess variance of this exposure so far; zero at first.
  const VarianceExcess& excess(float exposure) const;

 private:
  static int slot_of(float exposure);
  void take_all(int channel, const Seen& predicted, const Image<float>& confidence);
  void learn(std::size_t channel, VarianceExcess& slot);

  // From the current frame: at most kCapacity of its pixels, picked evenly.
  struct Bin {
    static constexpr std::size_t kCapacity = 2048;
    std::vector<float> residuals;  // relative exposure
    std::vector<float> predicted;  // its variance by noise, response and state, without the excess
    std::size_t seen = 0;
    void add(float residual, float variance);
  };
  std::array<std::array<Bin, VarianceExcess::kBins>, 3> bins_;
  std::map<int, VarianceExcess> excess_;  // by half stops of exposure
};

}  // namespace hdrcam
