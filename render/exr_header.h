// The attributes of a picture in the header of an OpenEXR file, as its library has them, both ways.
// Reentrant.
#pragma once

#include <ImfForward.h>

#include "render/exr.h"

namespace hdrcam {

void add_attributes(const ExrAttributes& attributes, Imf::Header& header);
ExrAttributes attributes_of(const Imf::Header& header);

}  // namespace hdrcam
