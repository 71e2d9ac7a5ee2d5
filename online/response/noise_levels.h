// How far a sensor's own noise spreads the codes of one light, by code, from the first frames of a stream. A
// photon counts alike whatever curve follows, so the spread of a code tells the curve's slope there (Anscombe
// 1948; noise level functions: Liu et al., CVPR 2006; radiometric calibration from them: Matsushita and Lin,
// CVPR 2007), also where no two exposures show the same light. Only a sensor's own noise does: it differs
// from channel to channel, and compression, noise reduction and texture do not. Thread-bound.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "capture/exposed_frame.h"

namespace hdrcam {

struct NoiseLevel {
  float code;    // 0..255, of the frames as given
  float spread;  // codes rms, quantisation taken off
  float error;   // of ln spread, rms
};

class NoiseLevels {
 public:
  // code_step: of the quantiser, in codes of 255; 0 where its steps are even in light, not in codes. bits: of
  // the camera's codes.
  explicit NoiseLevels(float code_step = 1, int bits = 8);

  // Frames of one gain count: that of the first; damaged ones do not. Unpacked without a black level. What
  // many frames have shown of a brightness is enough.
  void add(const ExposedFrame& frame);

  // [rgb], dark to bright; none in any where the noise is not the sensor's own.
  std::array<std::vector<NoiseLevel>, 3> levels() const;

 private:
  static constexpr int kBins = 33;

  struct Tile {
    float code;              // mean
    float contrast;          // codes: range of coarse means in and around it
    float variance, coarse;  // codes^2: of what neighbours do not predict, and of that at half the size
    std::array<float, 2> shared, other;  // with the other channels: covariance, and variance of that channel
  };
  struct Bin;  // of brightness

  void add_tile(const Image<float>& codes, int y0, int x0);
  std::optional<Bin> flattest(std::vector<Tile> tiles) const;

  float code_step_;
  float least_variance_;  // codes^2, with quantisation: of less, quantisation is too much
  float gain_ = 0;        // of the frames; 0: none yet
  std::array<std::array<std::vector<Tile>, kBins>, 3> tiles_;
};

}  // namespace hdrcam
