// Names and colours of provenance: one of each per value, the same in pictures, charts and legends. The
// colours are distinct for colour-blind users (Okabe and Ito 2008).
#pragma once

#include <array>

#include "firmware_host/sinks/rgb.h"
#include "render/hdr_frame.h"

namespace hdrcam {

struct ProvenanceLook {
  Provenance provenance;
  const char* key;   // in files
  const char* name;  // for display
  Rgb colour;
};

inline constexpr std::array kProvenanceLooks{
    ProvenanceLook{Provenance::Own, "own", "own sample", {0, 114, 178}},
    ProvenanceLook{Provenance::Carried, "carried", "carried", {0, 158, 115}},
    ProvenanceLook{Provenance::LookAhead, "look_ahead", "look-ahead", {230, 159, 0}},
    ProvenanceLook{Provenance::Field, "field", "field", {204, 121, 167}},
    ProvenanceLook{Provenance::Bound, "bound", "clipped bound", {213, 94, 0}},
};

}  // namespace hdrcam
