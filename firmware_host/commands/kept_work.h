// The flag --force: without it no output replaces an earlier take, and with or without it none replaces an
// input, the file of --config among them (sinks/output_guard.h). All verbs that write files share it.
// Thread-bound.
#pragma once

#include <optional>
#include <vector>

#include "firmware_host/command_line.h"
#include "firmware_host/sinks/output_guard.h"

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

}  // namespace hdrcam
