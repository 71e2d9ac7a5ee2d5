// Measures what a camera's own processing leaves in textured places: demosaicing, noise reduction, sharpening
// and compression change a pixel by its surroundings, so that no sample is better than a share of the local
// contrast, however bright it is. New frames are compared with the state where it is sure of the motion and
// contrast exceeds the noise; imperfect matches leave a share, too, and only what exceeds theirs counts.
// Thread-bound; the result does not depend on the number of threads.
#pragma once

#include <optional>
#include <vector>

#include "hal/core/worker_pool.h"
#include "online/state/state_comparison.h"

namespace hdrcam {

// What interpolating a mosaic of colours leaves (capture/demosaic.h), which matches of smooth places hide.
inline constexpr float kTextureErrorOfMosaic = 0.02f;

class TextureError {
 public:
  // least: the share that is known before any comparison.
  explicit TextureError(WorkerPool& pool, float least = 0) : pool_(pool), least_(least) {}

  // Learns from a frame and the state of the frame before.
  void observe(const StateComparison& seen);

  // The share of the local contrast (variance of 3x3 pixels) that a sample's variance has on top of its
  // noise; it is measured over the 4x4 pixels between which the state is read, whose contrast is the larger
  // one in smooth gradients. `least` for cameras that leave textures alone.
  float share() const;

 private:
  static std::size_t compare_line(const StateComparison& seen, int y, float* shares);
  static std::optional<float> compare(const StateComparison& seen, int channel, int y, int x);

  WorkerPool& pool_;
  const float least_;
  std::vector<float> shares_;       // of the current frame, line by line
  std::vector<std::size_t> found_;  // in each line
  // The share as measured, with what imperfect matches leave. It starts at that of a sharp camera: the first
  // frames are compared with a state that is hardly better than they are.
  float disagreement_ = 0.03f;
};

}  // namespace hdrcam
