// Where 8-bit pictures at one exposure go (render/views/re_exposure.h): the sinks of a run whose frames hold
// display light instead of radiance. `frames` are PNG files with the camera's own codes, or an SDR video that
// shows their light in the codes of BT.709; the other sinks are those of sink_table.h. Reentrant.
#pragma once

#include <span>

#include "firmware_host/sinks/sink_table.h"

namespace hdrcam {

std::span<const SinkKind> ldr_sink_kinds();

}  // namespace hdrcam
