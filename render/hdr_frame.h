// The output of the pipeline: one HDR frame with its facts, its uncertainty and the source of each pixel.
// Radiance is scene-linear and relative: 1 saturates the clip's reference exposure E_ref. Move-only value.
#pragma once

#include <cstdint>

#include "hal/core/frame.h"
#include "hal/core/image.h"

namespace hdrcam {

enum class Provenance : std::uint8_t {
  Own = 0,        // mostly this frame's own sample
  Carried = 1,    // mostly earlier frames, carried along the motion
  LookAhead = 2,  // mostly a later frame
  Field = 3,      // unseen or badly seen: from the field
  Bound = 4,      // clipped in all frames: a lower bound
};

struct HdrFrame {
  FrameFacts facts;
  float exposure = 1;              // E / E_ref of the frame it belongs to
  double reference_exposure = 1;   // E_ref, seconds x gains
  float white = 1;                 // radiance that saturates the shortest exposure of the cycle
  Image<float> radiance;           // [rgb, rows, cols], finite, >= 0
  Image<float> sigma;              // [1, rows, cols] standard deviation of ln radiance
  Image<std::uint8_t> provenance;  // [1, rows, cols] Provenance
  Image<float> depth;  // [1, rows, cols] in units of the field's near plane; empty without the field
  Image<float> flow;   // [dx dy, rows, cols] to the previous frame, pixels; empty for the first
  // The field's own motion to the previous frame, as flow; empty where it was not requested.
  Image<float> field_flow;
};

// Facts, radiance, sigma and provenance; what depends on the field or on the neighbours stays. `to` keeps its
// memory.
inline void copy_picture(const HdrFrame& from, HdrFrame& to) {
  to.facts = from.facts;
  to.exposure = from.exposure;
  to.reference_exposure = from.reference_exposure;
  to.white = from.white;
  to.radiance.copy_from(from.radiance);
  to.sigma.copy_from(from.sigma);
  to.provenance.copy_from(from.provenance);
}

}  // namespace hdrcam
