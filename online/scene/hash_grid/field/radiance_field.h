// The field as whoever looks reads it: the window's frames and the networks over them, of the fit itself
// between two steps, or of a snapshot. Borrowed; reentrant to read.
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
