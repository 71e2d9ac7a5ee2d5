// The field as a renderer reads it: the window's frames and the networks over them. Immutable between two
// steps of the fit. Reentrant to read.
#pragma once

#include "online/field/field.h"

namespace hdrcam {

struct RadianceField {
  Window window;
  FieldNetworks<float> networks;
  int samples_per_ray = 8;
  bool has_dynamic = true;  // false where nothing in the window moves
};

}  // namespace hdrcam
