// The field as a renderer reads it: the window's frames and the networks, of the fit itself between two steps
// or of a snapshot. Borrowed; reading is reentrant.
#pragma once

#include "online/scene/hash_grid/field/field.h"

namespace hdrcam {

struct RadianceField {
  const WindowFrames& window;
  const FieldNetworks<float>& networks;
  int samples_per_ray = 8;
  bool has_dynamic = true;  // false where nothing in the window moves
};

}  // namespace hdrcam
