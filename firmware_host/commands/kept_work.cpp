#include "firmware_host/commands/kept_work.h"

namespace hdrcam {
namespace {

// The file of --config; empty where there is none.
std::vector<NamedInput> configuration_of(CommandLine verb) {
  if (const auto file = verb.given("--config")) return {{"the configuration", *file}};
  return {};
}

}  // namespace

void KeptWork::add_to(CommandLine verb) {
  add_without_force(verb);
  verb.add_switch("--force", force_, "replace outputs of an earlier run");
}

void KeptWork::add_without_force(CommandLine verb) { verb_ = verb; }

Result<void> KeptWork::check(Storage& storage, const std::vector<NamedInput>& inputs,
                             const std::vector<NamedOutput>& outputs) const {
  std::vector<NamedInput> read = configuration_of(*verb_);
  read.insert(read.end(), inputs.begin(), inputs.end());
  TRY(check_outputs(storage, read, outputs, force_ ? Overwrite::Force : Overwrite::Refuse));
  return make_room_for(storage, outputs);
}

}  // namespace hdrcam
