// The flag --force: without it no output replaces an earlier take, and with or without it none replaces an
// input, the file of --config among them (sinks/output_guard.h). All verbs that write files share it.
// Thread-bound.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "firmware_host/command_line.h"
#include "firmware_host/settings/settings.h"
#include "firmware_host/sinks/output_guard.h"
#include "firmware_host/sinks/sink_table.h"

namespace hdrcam {

class KeptWork {
 public:
  void add_to(CommandLine verb);             // --force; the verb outlives this
  void add_without_force(CommandLine verb);  // for a verb whose outputs every run replaces
  bool replaces() const { return force_; }

  // Also makes the folders of the outputs. Errors: those of check_outputs and of make_room_for.
  Result<void> check(Storage& storage, const std::vector<NamedInput>& inputs,
                     const std::vector<NamedOutput>& outputs) const;

 private:
  std::optional<CommandLine> verb_;
  bool force_ = false;
};

// The outputs of a run with these sinks, its trace among them. What other sinks, or other verbs, would write
// by the same settings is none.
std::vector<NamedOutput> outputs_of(const Settings& settings, std::span<const SinkKind> sinks);
// The file of --config; empty where there is none.
std::vector<NamedInput> configuration_of(CommandLine verb);
// The files of a clip with ground truth: its clip.json, its pictures and its truth.
std::vector<NamedInput> files_of_clip(const std::string& folder);
// Invalid where a file is named, such as a recording, and a folder is needed. wanted: what to name.
Result<void> check_folder(Storage& storage, const std::string& path, const char* wanted);
Result<void> check_clip_folder(Storage& storage, const std::string& path);  // of a clip with ground truth
// The recording that a camera "replay:FILE" reads; empty for any other camera.
std::vector<NamedInput> inputs_of(const Settings::Camera& camera);

}  // namespace hdrcam
