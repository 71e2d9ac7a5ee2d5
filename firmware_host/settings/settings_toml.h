// Settings as a TOML file: the tables and keys of the list of fields, nothing else. Reentrant.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "firmware_host/settings/setting_field.h"
#include "hal/core/result.h"

namespace hdrcam {

// A file beyond these is not one of settings.
constexpr std::size_t kMostTomlBytes = 64 << 10;
constexpr std::size_t kMostTomlDots = 2000;

// Sets what the text sets and leaves the rest; after an error, settings hold what came before it. Lists
// (shutter, gain, control_delay, layers) may be arrays or texts with commas. Errors: Invalid, one sentence
// that begins with "NAME:LINE:", the first one of the file.
Result<void> read_toml(std::string_view text, const std::string& name, Settings& settings);

// These settings as a TOML file with a comment for each: what --print-config prints, and what reads back as
// the same settings. The second form: those of these groups.
std::string to_toml(const Settings& settings, const std::vector<const SettingField*>& fields);
std::string to_toml(const Settings& settings, const std::vector<SettingGroup>& groups);

}  // namespace hdrcam
