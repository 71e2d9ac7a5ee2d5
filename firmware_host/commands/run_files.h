// The files of a run as the guard of outputs takes them (sinks/output_guard.h): what its settings have it
// write, and what it reads. Reentrant.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "firmware_host/settings/settings.h"
#include "firmware_host/sinks/output_guard.h"
#include "firmware_host/sinks/sink_table.h"
#include "hal/core/result.h"
#include "hal/storage.h"

namespace hdrcam {

// The outputs of a run with these sinks, its trace among them. What other sinks, or other verbs, would write
// by the same settings is none.
std::vector<NamedOutput> outputs_of(const Settings& settings, std::span<const SinkKind> sinks);

// The files of a clip with ground truth: its clip.json, its pictures and its truth.
std::vector<NamedInput> files_of_clip(const std::string& folder);
// The recording that a camera "replay:FILE" reads; empty for any other camera.
std::vector<NamedInput> inputs_of(const Settings::Camera& camera);

// Invalid where a file is named, such as a recording, and a folder is needed. wanted: what to name.
Result<void> check_folder(Storage& storage, const std::string& path, const char* wanted);
Result<void> check_clip_folder(Storage& storage, const std::string& path);  // of a clip with ground truth

}  // namespace hdrcam
