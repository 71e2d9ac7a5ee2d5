// The list of all settings. The flags, the file, the help, the printed configuration and
// docs/configuration.md all come from this list, so they cannot disagree. Reentrant.
#pragma once

#include <span>

#include "firmware_host/settings/setting_field.h"

namespace hdrcam {

// In the order in which they are printed: group by group.
std::span<const SettingField> setting_fields();

const char* title(SettingGroup group);  // "Sync and trigger lines"

// The field's flag for a verb of these groups: --record is -o where no HDR frames are written.
const char* flag_of(const SettingField& field, std::span<const SettingGroup> groups);

}  // namespace hdrcam
