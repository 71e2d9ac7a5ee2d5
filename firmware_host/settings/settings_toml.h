// Settings as a TOML file: the tables and keys of the list of fields, nothing else. Reentrant.
#pragma once

#include <string>
#include <string_view>

#include "firmware_host/settings/settings.h"

namespace hdrcam {

// A file beyond these is not one of settings.
constexpr std::size_t kMostTomlBytes = 64 << 10;
constexpr std::size_t kMostTomlDots = 2000;

// Sets what the text sets and leaves the rest; after an error, settings hold what came before it. Lists
// (shutter, gain, control_delay, layers) may be arrays or texts with commas. Errors: Invalid, one sentence
// that begins with "NAME:LINE:", the first one of the file.
Result<void> read_toml(std::string_view text, const std::string& name, Settings& settings);

}  // namespace hdrcam
