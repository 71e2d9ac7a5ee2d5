// Settings as a TOML file: the tables and keys of the list of fields, nothing else. Reentrant.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "firmware_host/settings/setting_field.h"
#include "hal/core/result.h"

namespace hdrcam {

// A larger file is not a settings file.
constexpr std::size_t kMostTomlBytes = 64 << 10;
constexpr std::size_t kMostTomlDots = 2000;

// Changes only the settings in the text; after an error, those before it are set. Lists (shutter, gain,
// control_delay, layers) may be arrays or texts with commas. Errors: Invalid for the first mistake of the
// file, one sentence that begins with "NAME:LINE:". A knob that has two keys may have both, with one value.
Result<void> read_toml(std::string_view text, const std::string& name, Settings& settings);

// These settings as a TOML file with a comment for each: --print-config prints it, and it reads back as the
// same settings. The second form: those of these groups.
std::string to_toml(const Settings& settings, const std::vector<const SettingField*>& fields);
std::string to_toml(const Settings& settings, const std::vector<SettingGroup>& groups);

}  // namespace hdrcam
