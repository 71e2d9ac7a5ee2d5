// stats.json: the record of a run as JSON. The keys are specified in docs/stats.md. The sink is thread-bound.
#pragma once

#include <memory>
#include <string>

#include "firmware_host/sinks/frame_sink.h"
#include "hal/storage.h"

namespace hdrcam {

// Values that are not finite become null. Reentrant.
std::string to_json(const RunRecord& record);

// Writes the file when the run is concluded; creates its folder. The storage outlives the sink.
Result<std::unique_ptr<FrameSink>> create_stats(Storage& storage, const std::string& path);

}  // namespace hdrcam
