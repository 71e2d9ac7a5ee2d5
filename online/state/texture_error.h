// Measures what a camera's own processing leaves in textured places: demosaicing, noise reduction, sharpening
// and compression change a pixel by its surroundings, so that no sample is better than a share of the local
// contrast, however bright it is. New frames are compared with the state where it is sure of the motion and
// contrast exceeds the noise; imperfect matches leave a share, too, and only what exceeds theirs counts.
// Thread-bound; the pixels looked at do not depend on threads.
#pragma once

#include <vector>

#include "capture/exposed_frame.h"
#include "online/pictures/flow_field.h"
#include "online/state/exposure_tables.h"
#include "online/state/radiance_state.h"

namespace hdrcam {

class TextureError {
 public:
  // Compares a frame with the state of the frame before; to_previous: from the frame's pixels to the state's.
  // white: as known_limit() takes it.
  void observe(const ExposedFrame& frame, const RadianceState& state, const FlowField& to_previous,
               const ExposureTables& tables, float white);

  // The share of the local contrast (variance of 3x3 pixels) that a sample's variance has on top of its
  // noise. 0 for cameras that leave textures alone.
  float share() const;
  // As measured, with what imperfect matches leave. It starts at that of a sharp camera: the first frames
  // are compared with a state that is hardly better than they are.
  float disagreement() const { return disagreement_; }

 private:
  void compare(int channel, int y, int x, const ExposedFrame& frame, const RadianceState& state,
               const FlowField& to_previous, const ExposureTables& tables, float known);

  std::vector<float> shares_;  // of the current frame
  float disagreement_ = 0.03f;
};

}  // namespace hdrcam
