// What the fit knows of the next frames' scene, as far as their exposures matter: some hundred pixels of the
// state, spread over the last frames, each with its radiance in one channel, how far an exposure of a given
// time would blur it, and how well what is known of it is carried along: what moves unsteadily is followed
// badly, and is right only in frames that show it themselves. Radiance is relative to E_ref, as in the state.
// Fixed size; thread-bound.
#pragma once

#include <array>
#include <cstdint>

#include "online/frame_estimate.h"
#include "online/state/fusion.h"

namespace hdrcam {

class ScenePixels {
 public:
  static constexpr int kPixels = 768;
  static constexpr int kFrames = 4;           // over which the pixels are spread
  static constexpr int kLengths = 6;          // of exposures: a frame interval over 1, 2, 4 .. 32
  using Values = std::array<float, kPixels>;  // one for each pixel

  // fusion: of the state whose estimates it sees.
  explicit ScenePixels(const FusionOptions& fusion);

  // Takes pixels of a frame, in place of the oldest ones. A frame without motion to the one before is left
  // out.
  void see(const FrameEstimate& estimate);
  // Whether all pixels were taken.
  bool complete() const { return frames_ >= kFrames; }
  void forget() { frames_ = 0; }

  int channel(int pixel) const { return pixel % 3; }
  const Values& radiance() const { return radiance_; }
  // Variance that a step along the motion adds to what is known, and the share of that which is kept.
  const Values& misalignment() const { return misalignment_; }
  const Values& kept() const { return kept_; }
  // Squared blur of radiance if exposed for interval_s() / 2^length.
  const Values& squared_blur(int length) const { return squared_blur_[static_cast<std::size_t>(length)]; }
  double interval_s() const { return interval_s_; }  // between frames

 private:
  // pace: of the motion to the next frame against that from the one before
  void take(const FrameEstimate& estimate, float pace, int y, int x, std::size_t to);

  const float misaligned_;  // of the contrast: variance that a step adds
  Values radiance_{}, misalignment_{}, kept_{};
  std::array<Values, kLengths> squared_blur_{};
  double interval_s_ = 0;
  std::uint64_t frames_ = 0;
};

}  // namespace hdrcam
