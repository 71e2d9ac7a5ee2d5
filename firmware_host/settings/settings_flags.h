// The settings on a command line: a flag for each, --config and --print-config. The last one given in this
// order wins: default, file, flag; of two flags for one knob neither does. Thread-bound.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "firmware_host/command_line.h"
#include "firmware_host/settings/settings.h"
#include "hal/core/result.h"
#include "hal/storage.h"

namespace hdrcam {

class SettingsFlags {
 public:
  // Adds the flags of these groups to the verb, but for those of some keys; or of these keys.
  SettingsFlags(CommandLine verb, const std::vector<SettingGroup>& groups,
                const std::vector<std::string>& left_out = {});
  SettingsFlags(CommandLine verb, const std::vector<std::string>& keys);
  ~SettingsFlags();

  // Errors: those of reading the file; Invalid for TOML that does not parse, an unknown key, a value of
  // another type or outside its range, naming file, line and valid values, and for a knob that is set twice.
  // A file may hold keys of groups that this verb does not use: one file serves all verbs. The format of the
  // log holds from here on.
  Result<Settings> read(Storage& storage) const;
  // The same for a verb: with --print-config it prints the settings of this verb, and there are none to run
  // with.
  Result<std::optional<Settings>> read_or_print(Storage& storage) const;
  // Those of these settings that the command line set, as flags: "--width"; "--set" for "knobs". A switch
  // that it turned off asks for nothing and is not among them.
  std::vector<std::string> given(const std::vector<std::string>& keys) const;
  // The settings that differ from their default, as flags for a command line: " --preset fast".
  std::string as_flags(const Settings& settings) const;

 private:
  struct Given;
  std::string printed(const Settings& settings) const;

  std::unique_ptr<Given> given_;
};

}  // namespace hdrcam
