// The flag --force: without it no output replaces an input or an earlier take (sinks/output_guard.h). All
// verbs that write files share it. Thread-bound.
#pragma once

#include <vector>

#include "firmware_host/settings/settings.h"
#include "firmware_host/sinks/output_guard.h"

namespace CLI {
class App;
}

namespace hdrcam {

class KeptWork {
 public:
  void add_to(CLI::App& verb);  // --force

  // Also makes the folders of the outputs. Errors: those of check_outputs and of make_room_for.
  Result<void> check(Storage& storage, const std::vector<NamedInput>& inputs,
                     const std::vector<NamedOutput>& outputs) const;

 private:
  bool force_ = false;
};

// The outputs of a run: its sinks and its recording, with this verb's flags for them.
std::vector<NamedOutput> outputs_of(const Settings& settings, const char* recording_flag);
// The recording that a camera "replay:FILE" reads; empty for any other camera.
std::vector<NamedInput> inputs_of(const Settings::Camera& camera);

}  // namespace hdrcam
