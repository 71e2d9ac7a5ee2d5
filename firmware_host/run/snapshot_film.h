// Films a scene that a run saved (film/scene_snapshot.h): no source and no method, only the virtual camera
// and the sinks. Reentrant.
#pragma once

#include <string>

#include "firmware_host/run/run.h"

namespace hdrcam {

// plan: with a film, and without ground truth. snapshot: the file. However the film ends, frames emitted
// before are complete. Errors: those of load_scene, of the settings and of the disk; Interrupted.
Result<void> film_snapshot(const RunPlan& plan, const std::string& snapshot, Storage& storage);

}  // namespace hdrcam
