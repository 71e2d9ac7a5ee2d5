// Opens the sinks of a run, or of a film of a saved scene, as its plan asks for them. Reentrant.
#pragma once

#include <functional>

#include "firmware_host/run/run.h"
#include "firmware_host/run_pace.h"
#include "firmware_host/sinks/run_control.h"
#include "firmware_host/sinks/sink_set.h"
#include "hal/core/frame.h"
#include "hal/core/result.h"
#include "hal/storage.h"

namespace hdrcam {

// camera: of the frames that are worked on; sinks of a film see it at the film's rate. control: of a run on a
// camera, else null; it outlives the sinks, as the storage does. Errors: those of SinkSet::open.
Result<SinkSet> open_sinks(const RunPlan& plan, const CameraFacts& camera, RunPace pace, RunControl* control,
                           Storage& storage);

// The outcome of work that gives frames to these sinks. What it throws, such as std::bad_alloc, is thrown
// once they are finished: the frames that they have are whole.
Result<void> fed_by(const std::function<Result<void>()>& work, SinkSet& sinks);

}  // namespace hdrcam
